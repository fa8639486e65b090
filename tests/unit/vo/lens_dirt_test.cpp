// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/dirty_lenses.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/datasets/open_dataset.h"
#include "core/files/archive.h"
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

  /// Corners of the right image at that time: partners, and dirt of its own around (200, 300).
  std::vector<Eigen::Vector2d> RightCorners() const {
    std::vector<Eigen::Vector2d> corners;
    for (size_t i = 0; i < world_.size(); ++i) {
      if (i % 2 == 0) corners.emplace_back(std::fmod(world_[i].x() + shift_px_, 640.0) - 10.0, world_[i].y());
    }
    for (int i = 0; i < n_right_dirt; ++i) corners.emplace_back(200.0 + 9.0 * (i % 5), 300.0 + 9.0 * (i / 5));
    return corners;
  }

  int n_right_dirt = 0;

  void Clean() { dirt_.clear(); }

 private:
  std::vector<Eigen::Vector2d> world_;
  std::vector<Eigen::Vector2d> dirt_;
  bool is_far_;
  double shift_px_ = 0.0;
};

const FeatureMask kNoMask{cv::Mat()};

void Watch(Drive& drive, double shift_px, int frames, DirtyLenses& lenses, const FeatureMask& left_mask = kNoMask,
           const FeatureMask& right_mask = kNoMask) {
  for (int i = 0; i < frames; ++i) {
    lenses.Observe(drive.See(shift_px), drive.RightCorners(), left_mask, right_mask);
  }
}

TEST(LensDirt, DirtIsFoundWhileCameraMoves) {
  Drive drive(20);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 15, lenses);
  EXPECT_NEAR(lenses.left().CoveredShare(), 20.0 / 4800.0, 2.0 / 4800.0);
  EXPECT_LT((lenses.left().Place_px() - Eigen::Vector2d(430.0, 146.0)).norm(), 30.0);
  StereoFeatures features = drive.See(5.0);
  StereoLine rim;
  rim.left.segment = {{413.0, 134.0}, {448.0, 160.0}};
  StereoLine edge;
  edge.left.segment = {{413.0, 134.0}, {200.0, 160.0}};
  features.lines = {rim, edge};
  lenses.RemoveFrom(features);
  EXPECT_GE(lenses.n_removed(), 20);
  EXPECT_GT(features.points.size(), 570U) << "few corners of the world are as near";
  ASSERT_EQ(features.lines.size(), 1U);
  EXPECT_EQ(features.lines[0].left.segment.q, edge.left.segment.q);
}

// Their share is within the noise of that of other corners.
TEST(LensDirt, FewCornersOfDirtAreFoundWithTime) {
  Drive drive(2);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 5, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
  Watch(drive, 5.0, 20, lenses);
  EXPECT_GT(lenses.left().CoveredShare(), 0.0);
  EXPECT_LT((lenses.left().Place_px() - Eigen::Vector2d(416.0, 133.0)).norm(), 10.0);
}

TEST(LensDirt, MuchDirtIsFoundAtOnce) {
  Drive drive(300);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 1, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
  Watch(drive, 5.0, 1, lenses);
  EXPECT_GT(lenses.left().CoveredShare(), 0.03);
}

TEST(LensDirt, RightLensIsLearntByItsOwnCorners) {
  Drive drive(0);
  drive.n_right_dirt = 20;
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 40, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
  // A spot counts as dirt up to 10 px around, so not all of its cells are needed.
  EXPECT_GT(lenses.right().CoveredShare(), 5.0 / 4800.0);
  EXPECT_LE(lenses.right().CoveredShare(), 21.0 / 4800.0);
  const Eigen::Vector2d spot_px = lenses.right().Place_px();
  EXPECT_LT((spot_px - Eigen::Vector2d(218.0, 313.0)).norm(), 30.0);
  StereoFeatures features;
  for (const double away_px : {0.0, 200.0}) {
    const Eigen::Vector2d left_px = spot_px + Eigen::Vector2d(10.0 + away_px, 0.0);
    StereoPoint point;
    point.left.px = left_px;
    point.disparity_px = 10.0;
    features.points.push_back(point);
    StereoLine line;
    line.left.segment = {left_px - Eigen::Vector2d(1.0, 5.0), left_px + Eigen::Vector2d(1.0, 5.0)};
    line.disparity_p_px = line.disparity_q_px = 10.0;
    features.lines.push_back(line);
  }
  lenses.RemoveFrom(features);
  ASSERT_EQ(features.points.size(), 2U);
  EXPECT_FALSE(features.points[0].HasDepth()) << "its partner is on the dirt";
  EXPECT_FALSE(features.lines[0].HasDepth());
  EXPECT_TRUE(features.points[1].HasDepth());
  EXPECT_TRUE(features.lines[1].HasDepth());
}

// Spots of equal looks give partners that stay as well; what their rows have in common is no depth.
TEST(LensDirt, DirtThatMatchesOtherDirtIsFound) {
  Drive drive(40);
  drive.n_right_dirt = 60;
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 10, lenses);
  const double share = lenses.left().CoveredShare();
  const auto see = [&] {
    StereoFeatures features = drive.See(5.0);
    for (int i = 0; i < 40; ++i) {
      StereoPoint point;
      point.left.px = {300.0 + 9.0 * (i % 5), 300.0 + 9.0 * (i / 5)};
      point.disparity_px = 100.0;
      features.points.push_back(point);
    }
    return features;
  };
  for (int i = 0; i < 10; ++i) lenses.Observe(see(), drive.RightCorners(), kNoMask, kNoMask);
  EXPECT_GT(lenses.left().CoveredShare() - share, 20.0 / 4800.0);
}

TEST(LensDirt, StandingCameraLearnsNothing) {
  Drive drive(20);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 0.0, 100, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
  Watch(drive, 5.0, 15, lenses);
  const double share = lenses.left().CoveredShare();
  EXPECT_GT(share, 0.0);
  Watch(drive, 0.0, 100, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), share);
}

TEST(LensDirt, DistantCornersAreNoDirt) {
  Drive drive(20, true);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 50, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
}

// A part of the scene that only one image shows may stand still while the rest moves.
TEST(LensDirt, CornersWhosePartnerIsMaskedProveNothing) {
  cv::Mat left = cv::Mat(480, 640, CV_8UC1, cv::Scalar(255)), right = left.clone();
  left.colRange(200, 320).setTo(0);
  right.colRange(340, 460).setTo(0);
  Drive drive(20);
  drive.n_right_dirt = 60;
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 30, lenses, FeatureMask(left), FeatureMask(right));
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
  EXPECT_EQ(lenses.right().CoveredShare(), 0.0);
  Watch(drive, 5.0, 30, lenses);
  EXPECT_GT(lenses.left().CoveredShare(), 0.0);
  EXPECT_GT(lenses.right().CoveredShare(), 0.0);
}

TEST(LensDirt, CleanLensKeepsAllFeatures) {
  Drive drive(0);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 50, lenses);
  StereoFeatures features = drive.See(5.0);
  lenses.RemoveFrom(features);
  EXPECT_EQ(features.points.size(), 600U);
  EXPECT_EQ(lenses.n_removed(), 0);
}

TEST(LensDirt, CleanedLensIsForgotten) {
  Drive drive(20);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 30, lenses);
  ASSERT_GT(lenses.left().CoveredShare(), 0.0);
  drive.Clean();
  Watch(drive, 5.0, 45, lenses);
  EXPECT_EQ(lenses.left().CoveredShare(), 0.0);
}

TEST(LensDirt, StateContinuesTheSame) {
  Drive drive(20);
  DirtyLenses lenses(kLensCamera);
  Watch(drive, 5.0, 4, lenses);
  const std::vector<uint8_t> bytes = archive::ToBytes(lenses);
  DirtyLenses other(kLensCamera);
  archive::FromBytes(bytes, other);
  Drive same = drive;
  Watch(drive, 5.0, 3, lenses);
  Watch(same, 5.0, 3, other);
  EXPECT_EQ(archive::ToBytes(other), archive::ToBytes(lenses));
  EXPECT_GT(other.left().CoveredShare(), 0.0);
}

// Without it, the tracker takes the dirt for the world, and stands still (ATE 0.5 m).
TEST(LensDirt, TrackerFollowsWorldOfPoorTexture) {
  const auto dataset = OpenDataset("synthetic:whitewall?size=640x480&frames=60&dirt=30", "");
  const auto frames = test::RunOdometry(*dataset, VoOptions());
  EXPECT_LT(test::AbsoluteTrajectoryError(frames), 0.05);
}

}  // namespace
}  // namespace plslam::vo
