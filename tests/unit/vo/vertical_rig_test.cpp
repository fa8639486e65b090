// SPDX-License-Identifier: BSD-3-Clause
// Cameras one above the other: the recordings of a pair side by side, with each image turned by 90 degrees.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <memory>
#include <utility>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "tests/support/data_folder.h"
#include "tests/support/odometry_run.h"
#include "tests/unit/geometry/turned_rig.h"

namespace plslam::vo {
namespace {

class TurnedDataset : public Dataset {
 public:
  TurnedDataset(std::unique_ptr<Dataset> dataset, int quarters)
      : dataset_(std::move(dataset)),
        rig_(test::TurnedClockwise(dataset_->rig(), quarters)),
        code_(quarters == 1 ? cv::ROTATE_90_CLOCKWISE : cv::ROTATE_90_COUNTERCLOCKWISE) {}

  std::string name() const override { return dataset_->name(); }
  const RigCalibration& rig() const override { return rig_; }
  int size() const override { return dataset_->size(); }
  int64_t t_ns(int index) const override { return dataset_->t_ns(index); }
  StereoImages Read(int index) const override {
    StereoImages images = dataset_->Read(index);
    cv::rotate(images.left.clone(), images.left, code_);
    cv::rotate(images.right.clone(), images.right, code_);
    return images;
  }
  std::optional<SE3> GroundTruth(int index) const override {
    const std::optional<SE3> T_w_l = dataset_->GroundTruth(index);
    if (!T_w_l) return std::nullopt;
    return *T_w_l * dataset_->rig().left.T_b_cam.Inverse() * rig_.left.T_b_cam;
  }

 private:
  std::unique_ptr<Dataset> dataset_;
  RigCalibration rig_;
  int code_;
};

/// The largest angle between the turns of the recorded left camera since the first frame and the true ones.
double LargestTurnError_rad(const std::vector<test::OdometryFrame>& frames) {
  double largest = 0.0;
  for (const test::OdometryFrame& frame : frames) {
    const SE3 estimate = frames.front().T_odom_l.Inverse() * frame.T_odom_l;
    const SE3 truth = frames.front().T_w_l->Inverse() * *frame.T_w_l;
    largest = std::max(largest, estimate.rotation().angularDistance(truth.rotation()));
  }
  return largest;
}

/// A pair side by side and the same one turned are tracked alike, in the frame of the recorded left camera.
void ExpectTheSame(const std::string& location, int n_frames) {
  const VoOptions options;
  const auto beside = test::RunOdometry(*OpenDataset(location, ""), options, 1, n_frames);
  const double ate_m = test::AbsoluteTrajectoryError(beside);
  for (const int quarters : {1, 3}) {
    SCOPED_TRACE(location + " " + std::to_string(quarters));
    const TurnedDataset dataset(OpenDataset(location, ""), quarters);
    const auto above = test::RunOdometry(dataset, options, 1, n_frames);
    EXPECT_EQ(test::LostFrames(above), 0);
    EXPECT_NEAR(test::AbsoluteTrajectoryError(above), ate_m, 0.1 * ate_m + 0.0005);
    EXPECT_NEAR(LargestTurnError_rad(above), LargestTurnError_rad(beside), 0.0005);
  }
}

TEST(VerticalRig, RoomSideBySideAndOneAboveTheOther) { ExpectTheSame("synthetic:room?seed=3&size=320x240", 30); }

TEST(VerticalRig, EurocSideBySideAndOneAboveTheOther) {
  PLSLAM_REQUIRE_DATA(folder, "euroc_MH_01_a");
  ExpectTheSame(folder.string(), 40);
}

}  // namespace
}  // namespace plslam::vo
