// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/lens_dirt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/datasets/open_dataset.h"
#include "core/io/files/archive.h"
#include "tests/support/odometry_run.h"

namespace plslam::vo {
namespace {

const StereoCamera kLensCamera{400.0, 320.0, 240.0, 0.1, 640, 480};

/// Corners at random places, of which the right image shows two thirds, and `n_dirt` corners on the left lens around
/// (412, 133), which it does not show.
class Drive {
 public:
  explicit Drive(int n_dirt, bool is_far = false) : is_far_(is_far) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> u(0.0, 640.0);
    std::uniform_real_distribution<double> v(0.0, 480.0);
    for (int i = 0; i < 600; ++i) world_.emplace_back(u(random), v(random));
    for (int i = 0; i < n_dirt; ++i) dirt_.emplace_back(412.0 + 9.0 * (i % 5), 133.0 + 9.0 * (i / 5));
  }

  /// The pair after the world has moved by so many pixels more.
  StereoFeatures See(double shift_px) {
    shift_px_ += shift_px;
    StereoFeatures features;
    for (size_t i = 0; i < world_.size(); ++i) {
      StereoPoint point;
      point.left.px = {std::fmod(world_[i].x() + shift_px_, 640.0), world_[i].y()};
      if (i % 3 != 0) point.disparity_px = 10.0;
      features.points.push_back(point);
    }
    for (const Eigen::Vector2d& px : dirt_) {
      StereoPoint point;
      point.left.px = px;
      point.is_far = is_far_;
      features.points.push_back(point);
    }
    return features;
  }

  void Clean() { dirt_.clear(); }

 private:
  std::vector<Eigen::Vector2d> world_;
  std::vector<Eigen::Vector2d> dirt_;
  bool is_far_;
  double shift_px_ = 0.0;
};

void Watch(Drive& drive, double shift_px, int frames, LensDirt& lens) {
  for (int i = 0; i < frames; ++i) lens.Observe(drive.See(shift_px));
}

TEST(LensDirt, DirtIsFoundWhileCameraMoves) {
  Drive drive(20);
  LensDirt lens(kLensCamera);
  Watch(drive, 5.0, 15, lens);
  EXPECT_NEAR(lens.CoveredShare(), 20.0 / 4800.0, 2.0 / 4800.0);
  EXPECT_LT((lens.Place_px() - Eigen::Vector2d(430.0, 146.0)).norm(), 30.0);
  StereoFeatures features = drive.See(5.0);
  StereoLine rim;
  rim.left.segment = {{413.0, 134.0}, {448.0, 160.0}};
  StereoLine edge;
  edge.left.segment = {{413.0, 134.0}, {200.0, 160.0}};
  features.lines = {rim, edge};
  lens.RemoveFrom(features);
  EXPECT_GE(lens.n_removed(), 20);
  EXPECT_GT(features.points.size(), 570U) << "few corners of the world are as near";
  ASSERT_EQ(features.lines.size(), 1U);
  EXPECT_EQ(features.lines[0].left.segment.q, edge.left.segment.q);
}

TEST(LensDirt, MuchDirtIsFoundAtOnce) {
  Drive drive(300);
  LensDirt lens(kLensCamera);
  Watch(drive, 5.0, 1, lens);
  EXPECT_EQ(lens.CoveredShare(), 0.0);
  Watch(drive, 5.0, 1, lens);
  EXPECT_GT(lens.CoveredShare(), 0.03);
}

TEST(LensDirt, StandingCameraLearnsNothing) {
  Drive drive(20);
  LensDirt lens(kLensCamera);
  Watch(drive, 0.0, 100, lens);
  EXPECT_EQ(lens.CoveredShare(), 0.0);
  Watch(drive, 5.0, 15, lens);
  const double share = lens.CoveredShare();
  EXPECT_GT(share, 0.0);
  Watch(drive, 0.0, 100, lens);
  EXPECT_EQ(lens.CoveredShare(), share);
}

TEST(LensDirt, DistantCornersAreNoDirt) {
  Drive drive(20, true);
  LensDirt lens(kLensCamera);
  Watch(drive, 5.0, 50, lens);
  EXPECT_EQ(lens.CoveredShare(), 0.0);
}

TEST(LensDirt, CleanLensKeepsAllFeatures) {
  Drive drive(0);
  LensDirt lens(kLensCamera);
  Watch(drive, 5.0, 50, lens);
  StereoFeatures features = drive.See(5.0);
  lens.RemoveFrom(features);
  EXPECT_EQ(features.points.size(), 600U);
  EXPECT_EQ(lens.n_removed(), 0);
}

TEST(LensDirt, CleanedLensIsForgotten) {
  Drive drive(20);
  LensDirt lens(kLensCamera);
  Watch(drive, 5.0, 30, lens);
  ASSERT_GT(lens.CoveredShare(), 0.0);
  drive.Clean();
  Watch(drive, 5.0, 45, lens);
  EXPECT_EQ(lens.CoveredShare(), 0.0);
}

TEST(LensDirt, StateContinuesTheSame) {
  Drive drive(20);
  LensDirt lens(kLensCamera);
  Watch(drive, 5.0, 4, lens);
  const std::vector<uint8_t> bytes = archive::ToBytes(lens);
  LensDirt other(kLensCamera);
  archive::FromBytes(bytes, other);
  Drive same = drive;
  Watch(drive, 5.0, 3, lens);
  Watch(same, 5.0, 3, other);
  EXPECT_EQ(archive::ToBytes(other), archive::ToBytes(lens));
  EXPECT_GT(other.CoveredShare(), 0.0);
}

// Without it, the tracker takes the dirt for the world, and stands still (ATE 0.5 m).
TEST(LensDirt, TrackerFollowsWorldOfPoorTexture) {
  const auto dataset = OpenDataset("synthetic:whitewall?size=640x480&frames=60&dirt=30", "");
  const auto frames = test::RunOdometry(*dataset, VoOptions());
  EXPECT_LT(test::AbsoluteTrajectoryError(frames), 0.05);
}

}  // namespace
}  // namespace plslam::vo
