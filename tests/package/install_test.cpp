// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

#include "tests/package/installed_tree.h"
#include "tests/support/data_folder.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Installation = InstalledTree;

auto Lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

TEST_F(Installation, RunsAfterBeingMoved) {
  Install("runtime");
  fs::rename(prefix(), folder() / "moved away");
  ExpectThatItRuns(folder() / "moved away" / "bin");
  for (const char* file :
       {"share/plslam/orb.vocabulary", "share/plslam/config/plslam.yaml", "share/plslam/config/rigs/zed.yaml",
        "share/plslam/lcmtypes/pose_t.lcm", "share/man/man1/plslam.1.gz", "share/bash-completion/completions/plslam",
        "share/zsh/vendor-completions/_plslam", "share/fish/vendor_completions.d/plslam.fish",
        "share/plslam/systemd/plslam-vo@.service", "share/doc/plslam/README.md"}) {
    EXPECT_TRUE(fs::exists(folder() / "moved away" / file)) << file;
  }
}

TEST_F(Installation, SystemdAcceptsTheUnits) {
  Install("runtime");
  const fs::path units = prefix() / "share" / "plslam" / "systemd";
  int services = 0;
  for (const auto& entry : fs::directory_iterator(units)) {
    std::ifstream stream(entry.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_THAT(text, testing::Not(HasSubstr("@PLSLAM_BIN@"))) << entry.path();
    if (entry.path().extension() != ".service") continue;
    ++services;
    EXPECT_THAT(text, HasSubstr((prefix() / "bin").string())) << entry.path();
    EXPECT_THAT(text, HasSubstr("RestartSec=200ms"));
  }
  EXPECT_EQ(services, 9) << "one for each process, the recorder and the relay (camera: where it is built)";
  if (!Has("systemd-analyze")) GTEST_SKIP() << "no systemd-analyze here: units are not verified";
  // Templates are verified as instances; the names of others in [Unit] lead to them.
  EXPECT_EQ(Shell(fmt::format(
                "cd '{}' && for unit in *@.*; do cp \"$unit\" \"$(echo \"$unit\" | sed 's/@/@front/')\"; done\n"
                "SYSTEMD_UNIT_PATH=\"$PWD:\" systemd-analyze verify --man=no ./*@front.* ./plslam-relay.service",
                units.string())),
            0)
      << output();
  EXPECT_EQ(output(), "");
}

TEST_F(Installation, ExternalProgramUsesCore) {
  Install("dev");
  const std::string source = (SourceFolder() / "tests" / "package" / "consumer").string();
  ASSERT_EQ(Shell(fmt::format(
                "'{0}' -S '{1}' -B build -DCMAKE_PREFIX_PATH='{2}' && '{0}' --build build -j 2 && build/consumer "
                "&& build/all_of_core",
                CMAKE_PROGRAM, source, prefix().string())),
            0)
      << output();
  EXPECT_THAT(output(), HasSubstr("channels, 1 bytes, 4.0 m"));
}

/// Poses of the example with the installed odometry.
TEST_F(Installation, ExamplesTrackAndListen) {
  Install("dev");
  const std::string source = (prefix() / "share" / "doc" / "libplslam-dev" / "examples").string();
  ASSERT_EQ(Shell(fmt::format("'{0}' -S '{1}' -B examples -DCMAKE_PREFIX_PATH='{2}' && '{0}' --build examples -j 2",
                              CMAKE_PROGRAM, source, prefix().string())),
            0)
      << output();
  ASSERT_EQ(Shell("examples/stereo_odometry 'synthetic:room?frames=5&size=376x240' > odometry.txt"), 0) << output();
  EXPECT_EQ(Lines(Text("odometry.txt")), 5);
  EXPECT_EQ(Shell("examples/stereo_odometry nowhere"), 1);
  EXPECT_THAT(output(), HasSubstr("stereo_odometry: error: nowhere: "));
  // A private bus; the listener gets the poses from the first one on, however late it joins.
  const std::string url = fmt::format("udpm://239.255.76.67:{}?ttl=0", 20000 + getpid() % 12000);
  EXPECT_EQ(Shell(fmt::format("timeout 60 examples/listen '{0}' 5 > heard.txt & listener=$!; '{1}/plslam' run "
                              "'synthetic:room?frames=5&size=160x120' "
                              "--out run --url '{0}' --quiet > run.log 2>&1; wait $listener",
                              url, (BinaryFolder()).string())),
            0)
      << output();
  EXPECT_EQ(Lines(Text("heard.txt")), 5) << output();
}

}  // namespace
}  // namespace plslam::test
