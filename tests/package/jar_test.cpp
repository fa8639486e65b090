// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <filesystem>

#include "core/process/process_status.h"
#include "plslam/pose_t.hpp"
#include "tests/package/installed_tree.h"
#include "tests/support/data_folder.h"

namespace plslam::test {
namespace {

using Jar = InstalledTree;

TEST_F(Jar, LcmSpyDecodesARecordedStatus) {
  const std::string jar = PLSLAM_BUILD_DIR "/share/java/plslam.jar";
  if (!std::filesystem::exists(jar) || !Has("java"))
    GTEST_SKIP() << "no Java here, or no lcm.jar: there is no plslam.jar";
  {
    bus::BusOptions options;
    options.url = "file://" + (folder() / "log").string() + "?mode=w";
    bus::Bus bus(options, "vo");
    bus::StatusPublisher status("vo", options, bus);
    status.SetState("running", "all is well");
    bus.Publish(bus::kPose, pose_t{});
  }
  const std::string source = (SourceFolder() / "tests" / "package" / "DecodeLog.java").string();
  ASSERT_EQ(Shell(fmt::format("java -cp '{}:{}' '{}' log", jar, LCM_JAR, source)), 0) << output();
  EXPECT_THAT(output(), testing::HasSubstr("POSE pose_t\nSTATUS status_t vo\n"));
}

}  // namespace
}  // namespace plslam::test
