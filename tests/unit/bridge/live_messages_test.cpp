// SPDX-License-Identifier: BSD-3-Clause
#include "core/ros/live_messages.h"

#include <gtest/gtest.h>

#include <map>
#include <string>

#include "core/datasets/recordings/ros_messages.h"
#include "tests/unit/export/small_map.h"

namespace plslam {
namespace {

class Live : public testing::Test {
 protected:
  Live() {
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

  static SE3 PoseIn(const std::string& cdr) {
    return ParsePose(kRosOdometry, {reinterpret_cast<const uint8_t*>(cdr.data()), cdr.size()}, RosEncoding::kCdr);
  }
  void Add(int i, int64_t session = 1) {
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
  LiveMessages messages_{[this](const RosTopic& topic, int64_t, std::string cdr) {
    last_[std::string(topic.name)] = std::move(cdr);
    ++counts_[std::string(topic.name)];
  }};
};

TEST_F(Live, EveryLiveRowIsWritten) {
  Add(0);
  messages_.WriteImage(100, cv::Mat(48, 64, CV_8UC1, cv::Scalar(7)));
  messages_.WriteMap(Map());
  messages_.WriteGrid({SE3(), 0.0, 0.05, 0, 0, 1, 1, {OccupancyGrid::kFree}});
  messages_.WritePath();
  messages_.WriteDiagnostic({.name = "vo", .message = "running", .values = {}});
  for (const RosTopic& topic : RosTopics()) {
    EXPECT_EQ(counts_.contains(std::string(topic.name)), topic.is_live) << topic.name;
  }
  EXPECT_EQ(PoseIn(last_.at("/odom")).translation(), Eigen::Vector3d::Zero());
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
