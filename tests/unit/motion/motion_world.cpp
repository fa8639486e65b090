// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/motion/motion_world.h"

#include <cmath>
#include <numbers>

namespace plslam::test {

double MotionWorldMaker::Gauss() {
  const double radius = std::sqrt(-2.0 * std::log(Uniform(1e-12, 1.0)));
  return radius * std::cos(Uniform(0.0, 2.0 * std::numbers::pi));
}

Eigen::Vector3d MotionWorldMaker::PointInView(const StereoCamera& camera) {
  const double z = Uniform(2.0, 8.0);
  const double u = Uniform(60.0, camera.width_px - 60.0);
  const double v = Uniform(60.0, camera.height_px - 60.0);
  return {(u - camera.cx_px) * z / camera.f_px, (v - camera.cy_px) * z / camera.f_px, z};
}

Eigen::Vector3d MotionWorldMaker::Measure(const StereoCamera& camera, const Eigen::Vector3d& p, double px,
                                          double disparity_px) {
  Eigen::Vector3d uvd = camera.ProjectStereo(p);
  uvd.x() += px * Gauss();
  uvd.y() += px * Gauss();
  uvd.z() += disparity_px * Gauss();
  return uvd;
}

SE3 MotionWorldMaker::SmallMotion(double translation_m, double rotation_rad) {
  Vector6d x;
  for (int i = 0; i < 6; ++i) x(i) = Uniform(-1.0, 1.0) * (i < 3 ? translation_m : rotation_rad);
  return SE3::Exp(x);
}

PointCorrespondence MotionWorldMaker::Observe(const MotionWorld& world, const Eigen::Vector3d& p_ref,
                                              const MotionNoise& noise) {
  PointCorrespondence o;
  o.p_ref = p_ref;
  if (noise.landmark_px > 0.0) {
    const Eigen::Vector3d uvd = Measure(world.camera, p_ref, noise.landmark_px, noise.landmark_px);
    o.p_ref = world.camera.Backproject(uvd);
    o.covariance = world.camera.BackprojectCovariance(uvd, noise.landmark_px, noise.landmark_px);
  }
  o.uvd = Measure(world.camera, world.T_cur_ref * p_ref, noise.measurement_px, noise.disparity_px);
  if (noise.measurement_px > 0.0) o.sigma_px = noise.measurement_px;
  if (noise.disparity_px > 0.0) o.sigma_disparity_px = noise.disparity_px;
  return o;
}

LineCorrespondence MotionWorldMaker::Observe(const MotionWorld& world, const Segment3& segment_ref,
                                             const MotionNoise& noise) {
  LineCorrespondence o;
  const PointCorrespondence p = Observe(world, segment_ref.p, noise);
  const PointCorrespondence q = Observe(world, segment_ref.q, noise);
  o.segment_ref = {p.p_ref, q.p_ref};
  o.covariance_p = p.covariance;
  o.covariance_q = q.covariance;
  const Eigen::Vector3d direction = segment_ref.q - segment_ref.p;
  const Eigen::Vector3d cut_p = segment_ref.p + Uniform(-0.15, 0.15) * direction;
  const Eigen::Vector3d cut_q = segment_ref.q + Uniform(-0.15, 0.15) * direction;
  const Eigen::Vector3d uvd_p =
      Measure(world.camera, world.T_cur_ref * cut_p, noise.measurement_px, noise.disparity_px);
  const Eigen::Vector3d uvd_q =
      Measure(world.camera, world.T_cur_ref * cut_q, noise.measurement_px, noise.disparity_px);
  o.observed = {uvd_p.head<2>(), uvd_q.head<2>()};
  o.disparity_p_px = uvd_p.z();
  o.disparity_q_px = uvd_q.z();
  if (noise.measurement_px > 0.0) o.sigma_px = noise.measurement_px;
  if (noise.disparity_px > 0.0) o.sigma_disparity_p_px = o.sigma_disparity_q_px = noise.disparity_px;
  return o;
}

MotionWorld MotionWorldMaker::Make(int n_points, int n_lines, const MotionNoise& noise) {
  MotionWorld world;
  world.T_cur_ref = SmallMotion(0.2, 0.05);
  for (int i = 0; i < n_points; ++i) world.points.push_back(Observe(world, PointInView(world.camera), noise));
  for (int i = 0; i < n_lines; ++i) {
    const Eigen::Vector3d p = PointInView(world.camera);
    const Eigen::Vector3d q = p + Uniform(0.5, 1.5) * Eigen::Vector3d{Gauss(), Gauss(), 0.5 * Gauss()}.normalized();
    world.lines.push_back(Observe(world, Segment3{p, q}, noise));
  }
  return world;
}

}  // namespace plslam::test
