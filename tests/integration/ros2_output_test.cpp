// SPDX-License-Identifier: BSD-3-Clause
// Output of plslam_ros2, as another DDS hears it. The tests are vo_process, and publish its poses.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/grid_channel.h"
#include "core/bus/messages/submap_channel.h"
#include "core/ros/ros_topics.h"
#include "plslam/pose_t.hpp"
#include "tests/integration/bus_frames.h"
#include "tests/integration/ros2_robot.h"

namespace plslam::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// One frame later with each message, with the covariances of `Diagonal`; the map is turned about its vertical by a
/// quarter.
class PublishedPoses {
 public:
  explicit PublishedPoses(const std::string& url) : bus_(BusFrames::OptionsOf(url)), grid_(*bus_), submaps_(*bus_) {
    bus_.Start();
  }
  ~PublishedPoses() { bus_.Join(); }
  PublishedPoses(const PublishedPoses&) = delete;
  PublishedPoses& operator=(const PublishedPoses&) = delete;

  void Publish() {
    pose_t pose{};
    pose.header.t_ns = 10'000'000'000 + 50'000'000 * ++n_;
    pose.header.session = 1;
    pose.frame_id = n_;
    pose.state = 1;
    pose.anchored = 1;
    pose.keyframe_id = -1;
    const SE3 quarter(Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * M_PI, Eigen::Vector3d::UnitY())), {0.0, 0.0, 2.0});
    pose.T_w_odom = bus::ToMessage(quarter);
    pose.T_odom_c = bus::ToMessage(SE3(Eigen::Quaterniond::Identity(), {0.0, 0.0, 1.0}));
    pose.T_prev_c = bus::ToMessage(SE3());
    for (int i = 0; i < 6; ++i) pose.covariance[7 * i] = pose.motion_covariance[7 * i] = 1e-4 * (i + 1);
    bus_->Publish(bus::kPose, pose);
    if (n_ > 1) return;
    grid_.Publish({SE3(), 0.0, 0.05, 0, 0, 1, 1, {OccupancyGrid::kFree}});
    submaps_.Publish({0.05, {{0, {1, 0, SE3(), std::vector<SurfacePoint>(3)}}}}, bus::SubmapPublisher::Changes::kAll);
  }

 private:
  bus::test::RunningBus bus_;
  bus::GridPublisher grid_;
  bus::SubmapPublisher submaps_;
  int n_ = 0;
};

/// Expects a covariance with this diagonal alone.
void ExpectDiagonal(const json& covariance, const std::vector<double>& diagonal) {
  ASSERT_EQ(covariance.size(), 36U);
  for (size_t i = 0; i < 36; ++i) {
    EXPECT_NEAR(covariance[i].get<double>(), i % 7 == 0 ? diagonal[i / 7] : 0.0, 1e-9) << i;
  }
}

class Ros2Output : public Ros2 {
 protected:
  /// plslam_ros2 with the images of a namespace, on its own bus.
  std::unique_ptr<launcher::ChildProcess> StartFor(const std::string& space, int port,
                                                   const std::vector<std::string>& options, const std::string& log) {
    std::vector<std::string> arguments{
        "--left", space + "/stereo/left/image_raw", "--right", space + "/stereo/right/image_raw", "--url", Url(port)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    host_->Do([&] { poses_.push_back(std::make_unique<PublishedPoses>(Url(port))); });
    return Start(BinaryFolder() / "plslam_ros2", arguments, log);
  }
  static std::string Url(int port) { return fmt::format("udpm://239.255.76.67:{}?ttl=0", port); }

  /// Publishes poses on each bus until these processes have ended.
  void PublishUntil(std::vector<launcher::ChildProcess*> ends) {
    const auto have_ended = [&] {
      for (auto* process : ends) {
        if (!process->Poll()) return false;
      }
      return true;
    };
    ASSERT_TRUE(WholeRun::WaitFor([&] {
      for (const auto& poses : poses_) poses->Publish();
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      return have_ended();
    }));
  }

  std::vector<std::unique_ptr<PublishedPoses>> poses_;
};

// Two robots, and a third process that listens to the second one and writes no transform.
TEST_F(Ros2Output, RobotsInTwoNamespacesAreApart) {
  const auto one = StartFor("/one", 7701,
                            {"--namespace", "/one/plslam", "--publish-tf", "map", "--frame", "map=one/map", "--frame",
                             "odom=one/odom", "--frame", "base=one/base_link"},
                            "one.log");
  const auto two = StartFor(
      "/two", 7702,
      {"--namespace", "/two/plslam", "--publish-tf", "odom", "--frame", "base=body", "--frame", "camera=eye"},
      "two.log");
  const auto third = StartFor("/two", 7703, {"--namespace", "/three/plslam", "--publish-tf", "none"}, "three.log");
  const auto first_robot = StartRobot({kWorld, "20", "40", "space=/one", "listen_s=1"});
  const auto second_robot = Start(BinaryFolder().parent_path() / "tests/fast_dds_robot",
                                  {kWorld, "20", "60", "space=/two", "listen_s=1", "census"}, "second.json");
  PublishUntil({first_robot.get(), second_robot.get()});
  StopAll({one.get(), two.get(), third.get()});
  EXPECT_THAT(Log("one.log"), HasSubstr("ended: 40 frames, 0 unpaired, 0 rejected"));
  EXPECT_THAT(Log("two.log"), HasSubstr("ended: 60 frames, 0 unpaired, 0 rejected"));

  json heard = Heard();
  EXPECT_EQ(heard["odom_frames"], json({"one/odom", "one/base_link"}));
  EXPECT_EQ(heard["pose"]["frame"], "one/map");
  // The camera looks along x of the body: its x, y, z are -y, -z and x.
  ExpectDiagonal(heard["odom_covariance"], {3e-4, 1e-4, 2e-4, 6e-4, 4e-4, 5e-4});
  ExpectDiagonal(heard["velocity_covariance"], {0.12, 0.04, 0.08, 0.24, 0.16, 0.2});
  ExpectDiagonal(heard["pose"]["covariance"], {1e-4, 3e-4, 2e-4, 4e-4, 6e-4, 5e-4});
  for (const auto& [i, expected] : {std::pair(0, 2.0), std::pair(1, 1.0), std::pair(2, 0.0)}) {
    EXPECT_NEAR(heard["pose"]["numbers"][static_cast<size_t>(i)].get<double>(), expected, 1e-9) << heard["pose"];
  }

  heard = LastJson("second.json");
  EXPECT_EQ(heard["odom_frames"], json({"odom", "body"}));
  EXPECT_EQ(heard["pose"]["frame"], "map");
  // Both robots hear all transforms.
  std::vector<std::string> transforms, fixed;
  for (const auto& [frames, n] : heard["tf"].items()) transforms.push_back(frames);
  for (const auto& [frames, n] : heard["tf_static"].items()) fixed.push_back(frames);
  EXPECT_THAT(transforms, testing::UnorderedElementsAre("one/map one/odom", "odom body"));
  EXPECT_THAT(fixed, testing::UnorderedElementsAre("one/base_link one/camera_left", "body eye"));
  ASSERT_TRUE(heard["topics"].contains("rt/three/plslam/odom")) << heard << Log("three.log");
  EXPECT_GT(heard["topics"]["rt/three/plslam/odom"]["n"].get<int>(), 5) << heard["topics"];
  for (const char* topic : {"rt/three/plslam/map/grid", "rt/three/plslam/map/surfaces"}) {
    EXPECT_GT(heard["topics"][topic]["n"].get<int>(), 0) << heard["topics"];
  }
}

}  // namespace
}  // namespace plslam::test
