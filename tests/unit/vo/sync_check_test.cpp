// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/sync_check.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/datasets/open_dataset.h"
#include "core/files/archive.h"
#include "tests/support/odometry_run.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {
namespace {

const StereoCamera kSyncRig{
    .f_px = 400.0, .cx_px = 320.0, .cy_px = 240.0, .baseline_m = 0.1, .width_px = 640, .height_px = 480};
constexpr double kInterval_s = 0.05;

/// Two cameras on a body that nods, seen by points at different depths: where each is at a time, in seconds.
struct NoddingWorld {
  double late_s = 0.0;
  double longer_readout_s = 0.0;
  RowField field{};

  static double Row_px(int i, double t_s) {
    const double nod_px = 12.0 * std::sin(6.0 * t_s) + 5.0 * std::sin(10.0 * t_s);
    return 40.0 + 400.0 * ((i * 37) % 200) / 200.0 + nod_px * (1.0 + 0.3 * ((i * 13) % 7) / 7.0);
  }

  TrackedFrame Frame(int frame, std::mt19937& random) const {
    std::normal_distribution<double> normal;
    StereoFeatures features;
    const double t_s = frame * kInterval_s;
    for (int i = 0; i < 200; ++i) {
      StereoPoint point;
      point.left.px = {20.0 + 3.0 * i, Row_px(i, t_s)};
      point.disparity_px = 5.0 + i % 17;
      point.sigma_row_px = 0.1;
      const double y = (point.left.px.y() - kSyncRig.cy_px) / (0.5 * kSyncRig.height_px);
      const double then_s = t_s + late_s + 0.5 * longer_readout_s * y;
      point.row_offset_px = Row_px(i, then_s) - point.left.px.y() + 0.2 * normal(random) +
                            field.Offset_px(point.left.px - Eigen::Vector2d(point.disparity_px, 0.0));
      if (i % 10 == 0) point.row_offset_px += 3.0 * normal(random);
      point.left.px.y() += 0.3 * normal(random);
      features.points.push_back(point);
    }
    TrackedFrame tracked(features);
    for (int i = 0; i < 200; ++i) tracked.point_tracks[i] = {.landmark_id = 1000 - i, .age = frame};
    return tracked;
  }
};

SyncCheck Checked(const NoddingWorld& world, int n_frames) {
  SyncCheck check(kSyncRig);
  std::mt19937 random(3);
  for (int i = 0; i < n_frames; ++i) check.Observe(world.Frame(i, random), kInterval_s);
  return check;
}

TEST(SyncCheck, EstimatesTheDelayWithin20Frames) {
  RowField::Coefficients bent;
  bent << -2.0, 0.4, 0.3, -0.3, 0.6, 0.1;
  for (const double late_s : {0.005, -0.005, 0.020, 0.050, -0.050}) {
    for (const RowField& field : {RowField(), RowField(kSyncRig, bent, {})}) {
      const SyncCheck check = Checked({.late_s = late_s, .field = field}, 20);
      EXPECT_NEAR(check.late_s(), late_s, 0.1 * std::abs(late_s));
      EXPECT_EQ(check.longer_readout_s(), 0.0);
    }
  }
}

TEST(SyncCheck, CamerasInStepAreLeftAlone) {
  RowField::Coefficients bent;
  bent << -2.0, 0.4, 0.3, -0.3, 0.6, 0.1;
  for (const RowField& field : {RowField(), RowField(kSyncRig, bent, {})}) {
    for (const int n_frames : {2, 5, 20, 100}) {
      EXPECT_EQ(Checked({.field = field}, n_frames).late_s(), 0.0);
      EXPECT_EQ(Checked({.field = field}, n_frames).longer_readout_s(), 0.0);
    }
  }
}

TEST(SyncCheck, EstimatesALongerReadout) {
  const SyncCheck check = Checked({.longer_readout_s = 0.020}, 30);
  EXPECT_NEAR(check.longer_readout_s(), 0.020, 0.003);
  EXPECT_EQ(check.late_s(), 0.0);
}

TEST(SyncCheck, StandingCameraLearnsNothing) {
  SyncCheck check(kSyncRig);
  std::mt19937 random(3);
  for (int i = 0; i < 30; ++i) check.Observe(NoddingWorld{.late_s = 0.02}.Frame(0, random), kInterval_s);
  EXPECT_EQ(check.late_s(), 0.0);
}

TEST(SyncCheck, ContinuesAfterARestart) {
  const NoddingWorld world{.late_s = 0.01};
  SyncCheck check = Checked(world, 10);
  SyncCheck restored(kSyncRig);
  archive::FromBytes(archive::ToBytes(check), restored);
  std::mt19937 random(5);
  std::mt19937 again(5);
  for (int i = 10; i < 20; ++i) {
    check.Observe(world.Frame(i, random), kInterval_s);
    restored.Observe(world.Frame(i, again), kInterval_s);
  }
  EXPECT_NE(check.late_s(), 0.0);
  EXPECT_EQ(check.late_s(), restored.late_s());
}

double LateIn(const Dataset& dataset, int n_frames) {
  return test::RunOdometry(dataset, {}, 1, n_frames).back().late_s;
}

// The images of a late camera, 20 frames a second. If the camera is a whole frame late, most matches are found only
// when the delay is known.
TEST(SyncCheck, EstimatesTheDelayOfARenderedWorld) {
  for (const double late_ms : {5.0, 20.0, 50.0}) {
    const auto world = OpenDataset("synthetic:room?frames=30&right_late_ms=" + std::to_string(late_ms), "");
    EXPECT_NEAR(1e3 * LateIn(*world, late_ms < 50.0 ? 20 : 30), late_ms, 0.12 * late_ms);
  }
}

TEST(SyncCheck, WorldsInStepAreLeftAlone) {
  for (const char* world : {"room", "street", "corridor", "whitewall"}) {
    EXPECT_EQ(LateIn(*OpenDataset(std::string("synthetic:") + world + "?frames=30", ""), 30), 0.0) << world;
  }
  // Few points, most of them at edges of different depth.
  EXPECT_EQ(LateIn(*OpenDataset("synthetic:whitewall?frames=45&seed=3", ""), 45), 0.0);
}

}  // namespace
}  // namespace plslam::vo
