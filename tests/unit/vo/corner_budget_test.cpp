// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/corner_budget.h"

#include <gtest/gtest.h>

#include "core/files/archive.h"

namespace plslam::vo {
namespace {

/// Returns a frame with `n` corners, the strongest `n_snow` of them observed in only one image.
TrackedFrame FrameWith(int n, int n_snow) {
  StereoFeatures features;
  for (int i = 0; i < n; ++i) {
    StereoPoint point;
    point.left.px = {static_cast<double>(i % 640), static_cast<double>(i % 480)};
    point.left.response = i < n_snow ? 200.0F : 50.0F;
    point.disparity_px = i < n_snow ? -1.0 : 10.0;
    features.points.push_back(point);
  }
  return TrackedFrame(features);
}

TEST(CornerBudget, UnchangedInGoodWeather) {
  CornerBudget budget(1000);
  for (int i = 0; i < 10; ++i) budget.Observe(FrameWith(1000, 500));
  EXPECT_EQ(budget.max_points(), 1000);
}

TEST(CornerBudget, GrowsInSnowAndShrinksAfterwards) {
  CornerBudget budget(1000);
  budget.Observe(FrameWith(1000, 700));
  EXPECT_EQ(budget.max_points(), 3333);
  budget.Observe(FrameWith(3333, 500));
  EXPECT_EQ(budget.max_points(), 2000) << "less snow, but not little";
  budget.Observe(FrameWith(2000, 300));
  EXPECT_EQ(budget.max_points(), 1000);
  budget.Observe(FrameWith(1000, 1000));
  EXPECT_EQ(budget.max_points(), 4000) << "no more than that";
}

TEST(CornerBudget, DoesNotGrowWithFewCorners) {
  CornerBudget budget(1000);
  budget.Observe(FrameWith(300, 290));
  EXPECT_EQ(budget.max_points(), 1000);
  budget.Observe(FrameWith(0, 0));
  EXPECT_EQ(budget.max_points(), 1000);
}

TEST(CornerBudget, TrackedLandmarksCountAsUseful) {
  CornerBudget budget(1000);
  TrackedFrame frame = FrameWith(1000, 700);
  for (FeatureTrack& track : frame.point_tracks) track = {.landmark_id = 7, .age = 3};
  budget.Observe(frame);
  EXPECT_EQ(budget.max_points(), 1000);
}

TEST(CornerBudget, FeaturesOnBodiesAreNotUseful) {
  CornerBudget budget(1000);
  TrackedFrame frame = FrameWith(1000, 0);
  const auto on_body = [&frame](size_t n) {
    for (size_t i = 0; i < frame.point_tracks.size(); ++i) frame.point_tracks[i].body = i < n ? 0 : -1;
  };
  on_body(500);
  budget.Observe(frame);
  EXPECT_EQ(budget.max_points(), 1000) << "enough is left of the world";
  on_body(700);
  budget.Observe(frame);
  EXPECT_EQ(budget.max_points(), 2000) << "not as many as in snow";
  on_body(300);
  budget.Observe(frame);
  EXPECT_EQ(budget.max_points(), 1000);
}

TEST(CornerBudget, IsKeptForARestart) {
  CornerBudget budget(1000);
  budget.Observe(FrameWith(1000, 700));
  CornerBudget restored(1000);
  archive::FromBytes(archive::ToBytes(budget), restored);
  EXPECT_EQ(restored.max_points(), budget.max_points());
}

}  // namespace
}  // namespace plslam::vo
