// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/live_messages.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "core/datasets/recordings/ros_messages.h"
#include "tests/unit/export/small_map.h"

namespace plslam {
namespace {

class Live : public testing::Test {
 protected:
  explicit Live(std::optional<RobotFrames> robot = {})
      : messages_(
            [this](const RosTopic& topic, int64_t, std::string cdr) {
              last_[std::string(topic.name)] = std::move(cdr);
              ++counts_[std::string(topic.name)];
            },
            std::move(robot)) {
    // Rectified already: the right camera is 0.1 m beside the left one.
    RigCalibration rig;
    for (CameraCalibration* const camera : {&rig.left, &rig.right}) {
      camera->width_px = 64;
      camera->height_px = 48;
      camera->fx_px = camera->fy_px = 50.0;
      camera->cx_px = 32.0;
      camera->cy_px = 24.0;
      camera->model = "pinhole";
    }
    rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0});
    rig.baseline_m = 0.1;
    messages_.SetRig(rig);
  }

  static SE3 PoseIn(const std::string& cdr) { return ParsePose(kRosOdometry, Bytes(cdr), RosEncoding::kCdr); }
  static std::span<const uint8_t> Bytes(const std::string& cdr) {
    return {reinterpret_cast<const uint8_t*>(cdr.data()), cdr.size()};
  }
  /// The transforms in the last message of /tf_static.
  StaticFrames FixedFrames() const {
    StaticFrames frames;
    ParseTransforms(Bytes(last_.at("/tf_static")), RosEncoding::kCdr, &frames);
    return frames;
  }
  void Add(int i, SessionId session = 1) {
    robot::CameraPose pose;
    pose.t_ns = 100 * (i + 1);
    pose.T_odom_c = SE3(Eigen::Quaterniond::Identity(), {0.1 * i, 0.0, 0.0});
    messages_.AddPose(pose, session);
  }
  /// Number of poses in the last path.
  uint32_t PathSize() {
    messages_.WritePath();
    const std::string& cdr = last_.at("/path");
    uint32_t n = 0;  // after encoding, stamp, and the name of the frame
    std::memcpy(&n, cdr.data() + 4 + 8 + 4 + 4, sizeof(n));
    return n;
  }

  std::map<std::string, std::string> last_;
  std::map<std::string, int> counts_;
  LiveMessages messages_;
};

class LiveOfRobot : public Live {
 protected:
  explicit LiveOfRobot(RobotFrames frames = {.body = "one/base_link", .camera = "one/camera_left"})
      : Live(std::move(frames)) {}

  static Matrix6d CovarianceAtTheEnd(const std::string& cdr) {
    std::array<double, 36> numbers{};
    std::memcpy(numbers.data(), cdr.data() + cdr.size() - sizeof(numbers), sizeof(numbers));
    return Eigen::Map<const Matrix6d>(numbers.data());
  }
};

class LiveWithoutTf : public LiveOfRobot {
 protected:
  LiveWithoutTf() : LiveOfRobot({.writes_map = false, .writes_odom = false, .writes_camera = false}) {}
};

TEST_F(Live, EveryLiveRowIsWritten) {
  Add(0);
  messages_.WriteImage(100, cv::Mat(48, 64, CV_8UC1, cv::Scalar(7)));
  messages_.WriteMap(Map());
  messages_.WriteGrid({SE3(), 0.0, 0.05, 0, 0, 1, 1, {OccupancyGrid::kFree}});
  SurfaceCloud surfaces;
  surfaces.submaps[0].points.resize(1);
  messages_.WriteSurfaces(surfaces);
  messages_.WritePath();
  messages_.WriteDiagnostic({.name = "vo", .message = "running", .values = {}});
  for (const RosTopic& topic : RosTopics()) {
    EXPECT_EQ(counts_.contains(std::string(topic.name)), topic.is_live) << topic.name;
  }
  EXPECT_EQ(PoseIn(last_.at("/odom")).translation(), Eigen::Vector3d::Zero());
}

TEST_F(Live, StaticFrameNeedsNoMap) {
  Add(0);
  EXPECT_TRUE(FixedFrames().Find("world", "map"));
  Add(1);
  EXPECT_EQ(counts_["/tf_static"], 1);
}

// The camera looks along x of the body, and the map is turned about its z by a quarter.
TEST_F(LiveOfRobot, PoseHasItsCovarianceAlongTheMap) {
  robot::CameraPose pose;
  pose.t_ns = 100;
  pose.T_w_odom = SE3(Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * M_PI, Eigen::Vector3d::UnitY())), {0.0, 0.0, 2.0});
  pose.covariance = Vector6d(1, 2, 3, 4, 5, 6).asDiagonal();
  messages_.AddPose(pose, 1);
  const std::string& cdr = last_.at("/pose");
  EXPECT_EQ(FrameOf(Bytes(cdr), RosEncoding::kCdr), "map");
  const SE3 read = ParsePose(kRosPose, Bytes(cdr), RosEncoding::kCdr);
  EXPECT_LT((read.translation() - Eigen::Vector3d(2.0, 0.0, 0.0)).norm(), 1e-9);
  const Matrix6d expected = Vector6d(1, 3, 2, 4, 6, 5).asDiagonal();
  EXPECT_LT((CovarianceAtTheEnd(cdr) - expected).norm(), 1e-9) << CovarianceAtTheEnd(cdr);
}

TEST_F(LiveOfRobot, CameraIsOnTheBodyByItsName) {
  Add(0);
  EXPECT_TRUE(FixedFrames().Find("one/base_link", "one/camera_left"));
}

TEST_F(LiveWithoutTf, NoTransformIsWritten) {
  Add(0);
  messages_.WriteMap(Map());
  EXPECT_FALSE(last_.contains("/tf_static"));
  EXPECT_FALSE(last_.contains("/tf"));
  EXPECT_TRUE(last_.contains("/pose"));
}

TEST_F(Live, PathIsBoundedAndEndsAtTheNewestPose) {
  for (int i = 0; i < 10'000; ++i) Add(i);
  EXPECT_EQ(PathSize(), 10'000U);
  Add(10'000);
  EXPECT_EQ(PathSize(), 5001U);
  Add(10'001);
  EXPECT_EQ(PathSize(), 5002U);
  Add(10'002);
  EXPECT_EQ(PathSize(), 5002U);
  Add(10'003);
  EXPECT_EQ(PathSize(), 5003U);
  Add(0, 2);
  EXPECT_EQ(PathSize(), 1U);
}

}  // namespace
}  // namespace plslam
