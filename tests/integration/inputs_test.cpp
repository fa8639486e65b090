// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/io/images/png_codec.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

using test::WholeRun;

const std::string kInputsWorld = "synthetic:room?frames=40&size=376x240";

/// A run to which one input does not arrive: done, with this one warning, which its terminal has, too.
void ExpectTheOnlyWarning(std::vector<std::string> arguments, const std::string& code, const std::string& words) {
  WholeRun run;
  arguments.insert(arguments.begin(), "run");
  arguments.emplace_back("--strict");
  EXPECT_EQ(run.Run(arguments), 2) << run.Logs();
  const nlohmann::json summary = run.Summary();
  EXPECT_EQ(summary["completed"], true);
  ASSERT_EQ(summary["warnings"].size(), 1U) << summary["warnings"].dump(1);
  EXPECT_EQ(summary["warnings"][0]["code"], code);
  const std::string sentence = summary["warnings"][0]["sentence"];
  EXPECT_THAT(sentence, testing::HasSubstr(words));
  const std::string logs = run.Logs();
  const size_t at = logs.find("plslam: warning: " + sentence);
  ASSERT_NE(at, std::string::npos) << logs;
  EXPECT_EQ(logs.find("plslam: warning: " + sentence, at + 1), std::string::npos) << "once";
}

/// A recording in the layout of EuRoC that has only every second right image.
void WriteHalfOfTheRightImages(const Dataset& dataset, const fs::path& folder) {
  for (int camera = 0; camera < 2; ++camera) {
    const fs::path cam = folder / "mav0" / fmt::format("cam{}", camera);
    fs::create_directories(cam / "data");
    const CameraCalibration& c = dataset.rig().left;
    std::ofstream(cam / "sensor.yaml") << fmt::format(
        "sensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [1.0, 0.0, 0.0, {}, 0.0, 1.0, 0.0, 0.0,\n"
        "         0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [{}, {}]\n"
        "camera_model: pinhole\nintrinsics: [{}, {}, {}, {}]\ndistortion_model: radial-tangential\n"
        "distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n",
        camera * dataset.rig().baseline_m, c.width_px, c.height_px, c.fx_px, c.fy_px, c.cx_px, c.cy_px);
    std::ofstream list(cam / "data.csv");
    list << "#timestamp [ns],filename\n";
    for (int i = 0; i < dataset.size(); i += 1 + camera) {
      const StereoImages images = dataset.Read(i);
      const int64_t t_ns = 1'000'000'000 + images.t_ns;
      WritePng((cam / "data" / fmt::format("{}.png", t_ns)).string(), camera == 0 ? images.left : images.right, 1);
      list << fmt::format("{},{}.png\n", t_ns, t_ns);
    }
  }
}

TEST(MissingInput, MasksWithoutADetector) {
  ExpectTheOnlyWarning({kInputsWorld, "--set", "vo.masks.enabled=true", "--set", "bus.partner_wait_s=1"},
                       "masks_missing", "does the detector run on the same bus");
}

TEST(MissingInput, MotionOfTheRobot) {
  ExpectTheOnlyWarning({kInputsWorld, "--set", "vo.robot_motion.enabled=true", "--set", "bus.partner_wait_s=1"},
                       "robot_motion_missing", "adapter.robot_odometry");
}

TEST(MissingInput, HalfOfTheRightImages) {
  const WholeRun files;
  WriteHalfOfTheRightImages(*OpenDataset(kInputsWorld, ""), files.folder() / "half");
  ExpectTheOnlyWarning({(files.folder() / "half").string()}, "dataset", "20 of 40 images of");
}

TEST(MissingInput, HalfMaskedImagesAreNoError) {
  WholeRun run;
  const auto dataset = OpenDataset(kInputsWorld, "");
  cv::Mat mask(dataset->rig().left.height_px, dataset->rig().left.width_px, CV_8UC1, cv::Scalar(255));
  mask.colRange(0, mask.cols / 2).setTo(0);
  const std::string file = (run.folder() / "mask.png").string();
  WritePng(file, mask);
  EXPECT_EQ(run.Run({"run", kInputsWorld, "--set", "player.mask_left=" + file, "--strict"}), 0) << run.Logs();
}

// An option of another process is no error, since one command line may serve all of them.
TEST(MissingInput, OptionOfAnotherProcess) {
  WholeRun run;
  const launcher::ChildProcess player(
      test::BinaryFolder() / "player",
      {kInputsWorld, "--url", "memq://", "--set", "player.pace=lockstep", "--set", "vo.map.local_keyframes=10"},
      run.folder() / "player.log");
  const auto log = [&] { return ReadText(run.folder() / "player.log"); };
  EXPECT_TRUE(WholeRun::WaitFor([&] {
    return log().find(
               "--set vo.map.local_keyframes=10 has no effect here: player reads the sections player and bus") !=
           std::string::npos;
  })) << log();
  EXPECT_EQ(log().find("--set player.pace=lockstep has no effect"), std::string::npos);
  EXPECT_TRUE(WholeRun::WaitFor([&] {
    return log().find("waiting for the pose of frame 0: no vo_process is running on memq://") != std::string::npos;
  })) << log();
}

}  // namespace
}  // namespace plslam
