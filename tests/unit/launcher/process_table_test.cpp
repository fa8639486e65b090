// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/process_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

namespace plslam::launcher {
namespace {

using testing::Contains;
using testing::ElementsAre;

const ProcessRow& Row(const std::string& name) {
  const auto table = ProcessTable();
  return *std::find_if(table.begin(), table.end(), [&](const ProcessRow& row) { return row.name == name; });
}

long Place(const std::vector<std::string>& arguments, const std::string& argument) {
  return std::find(arguments.begin(), arguments.end(), argument) - arguments.begin();
}

TEST(ProcessTable, NamedOptionsOverrideSet) {
  RunOptions options;
  options.out = "out";
  options.features = "lines";
  options.overrides = {"vo.features.features=points", "vo.state_file="};
  const auto arguments = ArgumentsOf(Row("vo"), options);
  EXPECT_THAT(arguments, Contains("vo.features.features=points"));
  EXPECT_LT(Place(arguments, "vo.features.features=points"), Place(arguments, "vo.features.features=lines"));
  const std::string state = "vo.state_file=" + StateFileOf(options, "vo").string();
  EXPECT_LT(Place(arguments, state), Place(arguments, "vo.state_file=")) << "there is no option for it";
}

TEST(ProcessTable, RestartedRecorderWritesAnotherFile) {
  RunOptions options;
  options.record = "/x/run.lcm";
  const auto arguments = ArgumentsOf(Row("recorder"), options);
  EXPECT_EQ(arguments.front(), "record");
  EXPECT_EQ(arguments.back(), "/x/run.lcm");
  EXPECT_EQ(ArgumentsOfRestart(options, {"recorder", 1}, arguments).back(), "/x/run.lcm.2");
  EXPECT_EQ(ArgumentsOfRestart(options, {"recorder", 2}, arguments).back(), "/x/run.lcm.3");
}

TEST(ProcessTable, CameraReplacesThePlayer) {
  RunOptions options;
  EXPECT_TRUE(Row("player").wanted(options));
  EXPECT_FALSE(Row("camera").wanted(options));
  options.from_cameras = true;
  options.dataset = "rig.yaml";
  options.pace = "realtime";
  EXPECT_FALSE(Row("player").wanted(options));
  EXPECT_TRUE(Row("camera").wanted(options));
  EXPECT_STREQ(SourceOfFrames(options), "camera");
  const auto arguments = ArgumentsOf(Row("camera"), options);
  EXPECT_THAT(arguments, Contains("camera.rig=rig.yaml"));
  EXPECT_THAT(arguments, Contains("camera.pace=realtime"));
}

TEST(ProcessTable, RestartedPlayerResumesAfterTheNewestPose) {
  EXPECT_THAT(ArgumentsOfRestart({}, {"player", 1, {7, 123}}, {"a"}),
              ElementsAre("a", "--set", "player.resume_after=7@123"));
  EXPECT_THAT(ArgumentsOfRestart({}, {"camera", 1, {7, 123}}, {"a"}),
              ElementsAre("a", "--set", "camera.resume_after=7@123"));
  EXPECT_THAT(ArgumentsOfRestart({}, {"player", 1}, {"a"}), ElementsAre("a"));
  EXPECT_THAT(ArgumentsOfRestart({}, {"vo", 1, {7, 123}}, {"a"}), ElementsAre("a"));
}

}  // namespace
}  // namespace plslam::launcher
