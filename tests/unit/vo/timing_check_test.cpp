// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/timing_check.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/geometry/rectification.h"
#include "tests/support/odometry_run.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

constexpr double kTimingInterval_s = 0.05;

RigCalibration TimingRig() {
  CameraCalibration camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 400.0;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  RigCalibration rig;
  rig.left = rig.right = camera;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.0, 0.0));
  rig.baseline_m = 0.1;
  return rig;
}

/// A camera that winds its way past points and edges, whose right image is late and whose rows are read in turn.
class WindingWorld {
 public:
  WindingWorld(double late_s, double readout_s) : late_s_(late_s), readout_s_(readout_s) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> across(-3.0, 3.0);
    std::uniform_real_distribution<double> depth(2.0, 8.0);
    const auto place = [&] { return Eigen::Vector3d(across(random), across(random), depth(random)); };
    for (int i = 0; i < 150; ++i) points_.push_back(place());
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector3d p = place();
      lines_.push_back({p, p + Eigen::Vector3d(0.3 * across(random), 1.0, 0.1 * across(random))});
    }
  }

  static SE3 PoseAt(double t_s) {
    Vector6d x;
    x << 0.4 * std::sin(2.0 * t_s), 0.1 * std::sin(5.0 * t_s), 0.8 * t_s, 0.1 * std::sin(3.0 * t_s),
        0.2 * std::sin(2.5 * t_s), 0.05 * std::sin(4.0 * t_s);
    return SE3::Exp(x);
  }

  static Vector6d VelocityAt(double t_s) {
    constexpr double kStep_s = 1e-3;
    return (PoseAt(t_s - kStep_s).Inverse() * PoseAt(t_s + kStep_s)).Log() / (2.0 * kStep_s);
  }

  TrackedFrame Frame(int frame, bool with_points, bool with_lines, std::mt19937& random) const {
    const double t_s = frame * kTimingInterval_s;
    std::normal_distribution<double> noise(0.0, 0.2);
    StereoFeatures features;
    std::vector<TrackId> point_ids;
    std::vector<TrackId> line_ids;
    for (size_t i = 0; with_points && i < points_.size(); ++i) {
      const auto uvd = Measure(points_[i], nullptr, t_s);
      if (!uvd) continue;
      StereoPoint& point = features.points.emplace_back();
      point.left.px = {uvd->x() + noise(random), uvd->y() + noise(random)};
      point.disparity_px = uvd->z() + noise(random);
      point.sigma_px = point.sigma_disparity_px = 0.2;
      point.sigma_row_px = 0.1;
      point_ids.push_back(TrackId(i));
    }
    for (size_t i = 0; with_lines && i < lines_.size(); ++i) {
      const auto p = Measure(lines_[i].p, &lines_[i].q, t_s);
      const auto q = Measure(lines_[i].q, &lines_[i].p, t_s);
      if (!p || !q) continue;
      StereoLine& line = features.lines.emplace_back();
      line.left.segment = {{p->x() + noise(random), p->y()}, {q->x() + noise(random), q->y()}};
      line.disparity_p_px = p->z() + noise(random);
      line.disparity_q_px = q->z() + noise(random);
      line.sigma_px = line.sigma_disparity_p_px = line.sigma_disparity_q_px = 0.2;
      line_ids.push_back(TrackId(i));
    }
    TrackedFrame tracked(features);
    for (size_t i = 0; i < point_ids.size(); ++i) tracked.point_tracks[i] = {.landmark_id = point_ids[i], .age = 5};
    for (size_t i = 0; i < line_ids.size(); ++i) tracked.line_tracks[i] = {.landmark_id = line_ids[i], .age = 5};
    return tracked;
  }

 private:
  /// Pixel in the left camera displaced by `offset_m`, at the time of its row.
  std::optional<Eigen::Vector2d> Project(const Eigen::Vector3d& p_w, double t_s, double offset_m) const {
    Eigen::Vector2d px(0.0, 240.0);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d p_c = PoseAt(t_s + readout_s_ * px.y() / 480.0).Inverse() * p_w;
      if (p_c.z() < 0.5) return std::nullopt;
      px = {400.0 * (p_c.x() - offset_m) / p_c.z() + 319.5, 400.0 * p_c.y() / p_c.z() + 239.5};
    }
    if (px.x() < 0.0 || px.x() > 639.0 || px.y() < 0.0 || px.y() > 479.0) return std::nullopt;
    return px;
  }

  /// The disparity of an end of a segment is measured where the right segment crosses the row of the left one.
  std::optional<Eigen::Vector3d> Measure(const Eigen::Vector3d& p_w, const Eigen::Vector3d* other_w,
                                         double t_s) const {
    const auto left = Project(p_w, t_s, 0.0);
    const auto right = Project(p_w, t_s + late_s_, 0.1);
    if (!left || !right) return std::nullopt;
    double right_u = right->x();
    if (other_w != nullptr) {
      const auto other = Project(*other_w, t_s + late_s_, 0.1);
      if (!other || std::abs(other->y() - right->y()) < 1.0) return std::nullopt;
      right_u += (left->y() - right->y()) * (other->x() - right->x()) / (other->y() - right->y());
    }
    if (left->x() - right_u < 0.5) return std::nullopt;
    return Eigen::Vector3d(left->x(), left->y(), left->x() - right_u);
  }

  double late_s_;
  double readout_s_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Segment3> lines_;
};

TimingCheck Checked(const WindingWorld& world, bool with_points, bool with_lines, int n_frames) {
  const Rectification rectification = Rectify(TimingRig());
  TimingCheck check(rectification.camera, RollingShutter(rectification, 0.0, StampRow::kFirst));
  std::mt19937 random(7);
  for (int i = 0; i < n_frames; ++i) {
    const double t_s = i * kTimingInterval_s;
    check.Observe(world.Frame(i, with_points, with_lines, random), WindingWorld::PoseAt(t_s),
                  WindingWorld::VelocityAt(t_s), TimingCheck::Parameters::Zero(), kTimingInterval_s);
  }
  return check;
}

TEST(TimingCheck, FindsDelayWithEitherFeatureType) {
  for (const bool with_points : {true, false}) {
    for (const double late_s : {0.004, -0.008, 0.0}) {
      const auto late =
          Checked(WindingWorld(late_s, 0.0), with_points, !with_points, 60).EstimateOf(TimingCheck::kLate);
      ASSERT_TRUE(late.has_value());
      EXPECT_NEAR(late->value, late_s, 0.0004 + 0.05 * std::abs(late_s)) << with_points << " sigma " << late->sigma;
      EXPECT_EQ(late->DiffersFrom(0.0, 10.0), late_s != 0.0) << late->value << " sigma " << late->sigma;
    }
  }
}

TEST(TimingCheck, FindsReadoutWithEitherFeatureType) {
  for (const bool with_points : {true, false}) {
    for (const double readout_s : {0.025, 0.0}) {
      const auto readout = Checked(WindingWorld(0.0, readout_s), with_points, !with_points, 60)
                               .EstimateOf(TimingCheck::kReadoutOfTurning);
      ASSERT_TRUE(readout.has_value());
      EXPECT_NEAR(readout->value, readout_s, 3.0 * readout->sigma) << with_points;
      EXPECT_LT(readout->sigma, 0.0025);
      EXPECT_EQ(readout->DiffersFrom(0.0, 8.0), readout_s != 0.0) << readout->value << " sigma " << readout->sigma;
    }
  }
}

TEST(TimingCheck, DepthCamerasAreNotMeasured) {
  const Rectification rectification = Rectify(TimingRig());
  RollingShutter shutter(rectification, 0.0, StampRow::kFirst);
  shutter.SetDepthMap();
  TimingCheck check(rectification.camera, shutter);
  const WindingWorld world(0.004, 0.0);
  std::mt19937 random(7);
  for (int i = 0; i < 60; ++i) {
    check.Observe(world.Frame(i, true, true, random), WindingWorld::PoseAt(i * kTimingInterval_s),
                  WindingWorld::VelocityAt(i * kTimingInterval_s), TimingCheck::Parameters::Zero(),
                  kTimingInterval_s);
  }
  EXPECT_FALSE(check.EstimateOf(TimingCheck::kLate).has_value());
}

std::vector<test::OdometryFrame> RunOf(const std::string& options) {
  return test::RunOdometry(*OpenDataset("synthetic:" + options, ""), VoOptions());
}

TEST(TimingCheck, UnknownReadoutIsFoundAndApplied) {
  const auto global = RunOf("room?size=640x480&frames=80");
  const auto found = RunOf("room?size=640x480&frames=80&readout_ms=25");
  EXPECT_NEAR(found[60].readout_s, 0.025, 0.0025);
  const auto rest = [](const std::vector<test::OdometryFrame>& frames) {
    return test::AbsoluteTrajectoryError({frames.begin() + 60, frames.end()});
  };
  EXPECT_LT(rest(found), 2.0 * rest(global) + 0.0005) << rest(global);
  for (const test::OdometryFrame& frame : global) EXPECT_EQ(frame.readout_s, 0.0);
}

TEST(TimingCheck, DelayIsFoundInPoorTexture) {
  const auto late = RunOf("whitewall?size=640x480&frames=80&right_late_ms=4");
  EXPECT_NEAR(late[60].late_s, 0.004, 0.0004);
  EXPECT_LT(test::AbsoluteTrajectoryError(late), 0.01);
  const auto good = RunOf("whitewall?size=640x480&frames=80");
  for (const test::OdometryFrame& frame : good) EXPECT_EQ(frame.late_s, 0.0);
}

TEST(TimingCheck, WrongReadoutIsContradicted) {
  const auto dataset = OpenDataset("synthetic:room?size=640x480&frames=50&readout_ms=20", "");
  for (const double stated_ms : {20.0, 30.0}) {
    RigCalibration rig = dataset->rig();
    rig.left.readout_ms = rig.right.readout_ms = stated_ms;
    StereoFrontEnd front_end(rig, VoOptions());
    Odometry odometry(front_end.camera(), VoOptions(), front_end.shutter());
    StageTimer timer;
    for (int i = 0; i < dataset->size(); ++i) {
      const StereoImages images = dataset->Read(i);
      odometry.Track(images.t_ns, odometry.SeePair(front_end, images, timer));
    }
    EXPECT_EQ(odometry.calibration().found_readout_s(), 0.0);
    if (stated_ms == 20.0) {
      EXPECT_EQ(odometry.calibration().contradicting_readout_s(), 0.0);
    } else {
      EXPECT_NEAR(odometry.calibration().contradicting_readout_s(), 0.020, 0.003);
    }
  }
}

}  // namespace
}  // namespace plslam::vo
