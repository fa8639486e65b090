// SPDX-License-Identifier: BSD-3-Clause
// The source `gige` with two fake cameras of Aravis (Debian: aravis-tools), in a separate network.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/support/data_folder.h"
#include "tests/support/network_host.h"
#include "tests/support/shell.h"
#include "tests/unit/camera/gst_elements.h"

namespace plslam {
namespace {

TEST(GigeRun, TwoFakeCamerasGiveFrames) {
  if (const std::string& obstacle = test::NetworkHost::Obstacle(); !obstacle.empty()) GTEST_SKIP() << obstacle;
  if (!test::HasProgram("arv-fake-gv-camera-0.8")) {
    GTEST_SKIP() << "no arv-fake-gv-camera-0.8 here: apt-get install aravis-tools";
  }
  if (!test::MissingElement({"aravissrc"}).empty()) {
    GTEST_SKIP() << "no GStreamer element aravissrc here: apt-get install libaravis-0.8-0";
  }
  const ScratchFolder folder;
  folder.Write("rig.yaml",
               "rate_hz: 10\nbaseline_m: 0.1\nleft:\n  resolution_px: [512, 512]\n  focal_length_px: [400, 400]\n"
               "  principal_point_px: [256, 256]\nsource:\n  gige: [Aravis-Fake-GV01, Aravis-Fake-GV02]\n"
               "  max_skew_ms: 60\n");
  const test::NetworkHost host;
  host.Shell("ip addr add 127.0.0.2/8 dev lo");
  test::ShellResult result;
  // They free-run, and end with the shell that has started them.
  host.Do([&] {
    result = test::Shell(
        folder, fmt::format("arv-fake-gv-camera-0.8 -i 127.0.0.1 -s GV01 & left=$!\n"
                            "arv-fake-gv-camera-0.8 -i 127.0.0.2 -s GV02 & right=$!\n"
                            "trap 'kill $left $right' EXIT\n"
                            "timeout --preserve-status -s INT 8 '{}' run '{}' --out '{}'",
                            (test::BinaryFolder() / "plslam").string(), folder.Path("rig.yaml"), folder.Path("run")));
  });
  EXPECT_EQ(result.exit_code, 0) << result.out << result.error;
  const auto summary = nlohmann::json::parse(ReadText(folder.Path("run/summary.json")), nullptr, false);
  ASSERT_TRUE(summary.is_object()) << result.out << result.error;
  EXPECT_GT(summary["all_frames"], 20) << result.out << result.error << ReadText(folder.Path("run/logs/camera.log"));
}

}  // namespace
}  // namespace plslam
