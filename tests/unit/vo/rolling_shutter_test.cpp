// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/rolling_shutter.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "core/datasets/open_dataset.h"
#include "tests/support/odometry_run.h"

namespace plslam::vo {
namespace {

constexpr double kReadout_s = 0.025;

RigCalibration Rig() {
  CameraCalibration camera;
  camera.width_px = 640;
  camera.height_px = 480;
  camera.fx_px = camera.fy_px = 400.0;
  camera.cx_px = 319.5;
  camera.cy_px = 239.5;
  RigCalibration rig;
  rig.left = rig.right = camera;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.2, 0.0, 0.0));
  rig.baseline_m = 0.2;
  return rig;
}

Vector6d Velocity() {
  Vector6d velocity;
  velocity << 0.5, -0.2, 4.0, 0.1, -0.4, 0.2;
  return velocity;
}

/// Measures a point of the camera at the time of the stamp in the row in which the moving camera sees it.
Eigen::Vector3d Observe(const RollingShutter& shutter, const StereoCamera& camera, const Eigen::Vector3d& p_stamp) {
  Eigen::Vector3d uvd = camera.ProjectStereo(p_stamp);
  for (int i = 0; i < 20; ++i) {
    const double t_s = shutter.readout_s() * shutter.SharesOf(uvd.head<2>(), uvd.z()).left;
    uvd = camera.ProjectStereo(SE3::Exp(-t_s * Velocity()) * p_stamp);
  }
  return uvd;
}

TEST(RollingShutter, MovesPointsToTheStamp) {
  const Rectification rectification = Rectify(Rig());
  for (const auto& [name, stamp] : ChoicesOf(StampRow())) {
    const RollingShutter shutter(rectification, kReadout_s, stamp);
    for (const Eigen::Vector3d& p : {Eigen::Vector3d(1.0, 1.2, 4.0), Eigen::Vector3d(-2.0, -1.0, 9.0)}) {
      const Eigen::Vector3d uvd = Observe(shutter, rectification.camera, p);
      const Eigen::Vector3d moved = shutter.Moved(uvd, shutter.SharesOf(uvd.head<2>(), uvd.z()), Velocity());
      EXPECT_LT((moved - rectification.camera.ProjectStereo(p)).norm(), 1e-6) << name;
    }
  }
}

TEST(RollingShutter, StampIsTheTimeOfItsRow) {
  const Rectification rectification = Rectify(Rig());
  EXPECT_EQ(RollingShutter(rectification, kReadout_s, StampRow::kFirst).SharesOf({100.0, 0.0}, 5.0).left, 0.0);
  EXPECT_EQ(RollingShutter(rectification, kReadout_s, StampRow::kMiddle).SharesOf({100.0, 240.0}, 5.0).left, 0.0);
  EXPECT_EQ(RollingShutter(rectification, kReadout_s, StampRow::kLast).SharesOf({100.0, 480.0}, 5.0).left, 0.0);
}

TEST(RollingShutter, RightImageIsReadInItsOwnRows) {
  RigCalibration rig = Rig();
  rig.right.cy_px += 24.0;
  const Rectification rectification = Rectify(rig);
  const RowShares shares = RollingShutter(rectification, kReadout_s, StampRow::kFirst).SharesOf({320.0, 240.0}, 20.0);
  EXPECT_NEAR(shares.right - shares.left, 24.0 / 480.0, 0.01);
}

TEST(RollingShutter, EndsOfBentLinesMoveToTheEdge) {
  const Rectification rectification = Rectify(Rig());
  const StereoCamera& camera = rectification.camera;
  const RollingShutter shutter(rectification, kReadout_s, StampRow::kFirst);
  const Eigen::Vector3d a(0.8, -1.0, 3.0);
  const Eigen::Vector3d b(0.8, 1.2, 3.0);
  // The least-squares line u(v), d(v) through observations of the edge.
  Eigen::MatrixX2d A(41, 2);
  Eigen::MatrixX2d values(41, 2);
  for (int i = 0; i <= 40; ++i) {
    const Eigen::Vector3d uvd = Observe(shutter, camera, a + i / 40.0 * (b - a));
    A.row(i) << 1.0, uvd.y();
    values.row(i) << uvd.x(), uvd.z();
  }
  const Eigen::Matrix2d fit = (A.transpose() * A).inverse() * A.transpose() * values;
  const auto end = [&](int i) { return Eigen::Vector2d(fit(0, 0) + fit(1, 0) * A(i, 1), A(i, 1)); };
  StereoFeatures features;
  StereoLine& line = features.lines.emplace_back();
  line.left.segment = {end(0), end(40)};
  line.disparity_p_px = fit(0, 1) + fit(1, 1) * A(0, 1);
  line.disparity_q_px = fit(0, 1) + fit(1, 1) * A(40, 1);
  const StereoLine moved = RollingFrame(shutter, features).MovedBy(Velocity()).lines.front();
  const Segment2 truth{camera.Project(a), camera.Project(b)};
  const Eigen::Vector3d edge = LineThrough(truth);
  for (const Eigen::Vector2d& px : {moved.left.segment.p, moved.left.segment.q}) {
    EXPECT_LT(std::abs(edge.dot(px.homogeneous())), 0.1);
  }
  EXPECT_GT(std::abs(edge.dot(end(40).homogeneous())), 2.0) << "as observed";
  EXPECT_NEAR(moved.disparity_p_px, camera.FocalBaseline() / 3.0, 0.05);
  EXPECT_NEAR(moved.disparity_q_px, camera.FocalBaseline() / 3.0, 0.05);
}

double AteOf(const std::string& options) {
  const auto dataset = OpenDataset("synthetic:room?size=320x240&frames=80" + options, "");
  return test::AbsoluteTrajectoryError(test::RunOdometry(*dataset, VoOptions()));
}

TEST(RollingShutter, KnownReadoutHelpsOdometry) {
  const double global_m = AteOf("");
  const double unknown_m = AteOf("&readout_ms=25");
  const double known_m = AteOf("&readout_ms=25&readout_known=1");
  EXPECT_LT(known_m, 1.5 * global_m) << global_m;
  EXPECT_LT(known_m, 0.6 * unknown_m) << unknown_m;
}

}  // namespace
}  // namespace plslam::vo
