// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/network_host.h"
#include "tests/support/text_file.h"
#include "tools/launch/child_process.h"

namespace plslam::test {

inline constexpr const char* kWorld = "synthetic:room?size=376x240&frames=80";
/// URL of the bus.
inline constexpr const char* kBusUrl = "udpm://239.255.76.67:7667?ttl=0";
inline constexpr const char* kTopics = "/stereo/left/image_raw,/stereo/right/image_raw";

/// A robot of ROS 2 by Fast DDS, and plslam_ros2, on a host that has loopback alone.
class Ros2 : public testing::Test {
 protected:
  void SetUp() override {
    if (!NetworkHost::Obstacle().empty()) GTEST_SKIP() << NetworkHost::Obstacle();
    host_ = std::make_unique<NetworkHost>();
  }

  std::unique_ptr<launcher::ChildProcess> Start(const std::filesystem::path& program,
                                                const std::vector<std::string>& arguments, const std::string& log) {
    std::unique_ptr<launcher::ChildProcess> process;
    host_->Do([&] { process = std::make_unique<launcher::ChildProcess>(program, arguments, folder_.Path(log)); });
    return process;
  }
  /// plslam_ros2 alone: its frames have no readers.
  std::unique_ptr<launcher::ChildProcess> StartProcess(const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments{
        "--left", "/stereo/left/image_raw", "--right", "/stereo/right/image_raw", "--url", kBusUrl};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return Start(BinaryFolder() / "plslam_ros2", arguments, "ros2.log");
  }
  std::unique_ptr<launcher::ChildProcess> StartRobot(std::vector<std::string> options) {
    return Start(BinaryFolder().parent_path() / "tests/fast_dds_robot", options, "robot.json");
  }
  /// Runs `plslam run` without loops, and ends it after the robot.
  void RunWithRobot(const std::vector<std::string>& options, std::vector<std::string> robot_options) {
    std::vector<std::string> arguments{"run", fmt::format("ros2:{}", kTopics), "--out", folder_.Path("out"),
                                       "--no-loops"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const auto run = Start(BinaryFolder() / "plslam", arguments, "run.log");
    const auto robot = StartRobot(std::move(robot_options));
    Wait(*robot);
    run->Signal(SIGINT);
    Wait(*run);
    ASSERT_EQ(run->Poll()->code, 0) << Log("run.log");
  }
  static void Wait(launcher::ChildProcess& process) {
    ASSERT_TRUE(WholeRun::WaitFor([&] { return process.Poll().has_value(); }));
  }
  static void Stop(launcher::ChildProcess& process) { StopAll({&process}); }
  /// Stops them at the same time; a second SIGINT would kill them.
  static void StopAll(const std::vector<launcher::ChildProcess*>& processes) {
    for (auto* process : processes) process->Signal(SIGINT);
    for (auto* process : processes) {
      Wait(*process);
      EXPECT_EQ(process->Poll()->code, 0);
    }
  }
  std::string Log(const std::string& file = "ros2.log") const { return ReadText(folder_.Path(file)); }
  bool LogHas(const std::string& text) const {
    return WholeRun::WaitFor([&] { return Log().find(text) != std::string::npos; });
  }
  /// The answer of a program of tests/ros2.
  nlohmann::json Call(std::vector<std::string> arguments) {
    const std::string program = arguments.front();
    arguments.erase(arguments.begin());
    const auto caller = Start(BinaryFolder().parent_path() / "tests" / program, arguments, "caller.json");
    Wait(*caller);
    return LastJson("caller.json");
  }
  /// The messages that the robot received; warnings of Fast DDS come before.
  nlohmann::json Heard() const { return LastJson("robot.json"); }
  nlohmann::json LastJson(const std::string& file) const {
    const std::string text = Log(file);
    const size_t begin = text.rfind("\n{") == std::string::npos ? text.find('{') : text.rfind("\n{") + 1;
    return nlohmann::json::parse(text.substr(std::min(begin, text.size())), nullptr, false);
  }

  ScratchFolder folder_;
  std::unique_ptr<NetworkHost> host_;
};

}  // namespace plslam::test
