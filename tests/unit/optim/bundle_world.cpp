// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/optim/bundle_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plslam::test {
namespace {

constexpr double kStep_m = 0.15;
// Stated for measurements without noise.
constexpr double kExactSigma_px = 0.1;

double RootMean(double squares, double count) { return std::sqrt(squares / std::max(1.0, count)); }

}  // namespace

double BundleWorldMaker::Gauss() {
  const double radius = std::sqrt(-2.0 * std::log(Uniform(1e-12, 1.0)));
  return radius * std::cos(Uniform(0.0, 2.0 * std::numbers::pi));
}

void BundleWorldMaker::MakePoses(BundleWorld& world) {
  for (int i = 0; i < spec_.fixed_poses + spec_.free_poses; ++i) {
    Vector6d wobble;
    wobble << 0.03 * GaussVector(), 0.03 * GaussVector();
    const SE3 T_w_c = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(kStep_m * i, 0.0, 0.0)) * SE3::Exp(wobble);
    world.true_T_w_c.push_back(T_w_c);
    Vector6d start;
    start << spec_.start_m * GaussVector(), spec_.start_rad * GaussVector();
    const bool fixed = i < spec_.fixed_poses;
    world.problem.poses.push_back({fixed ? T_w_c : T_w_c * SE3::Exp(start), fixed});
  }
}

int BundleWorldMaker::FirstPose(const BundleWorld& world) {
  const int places = static_cast<int>(world.problem.poses.size()) - spec_.observations + 1;
  return std::clamp(static_cast<int>(Uniform(0.0, places)), 0, std::max(0, places - 1));
}

Eigen::Vector3d BundleWorldMaker::PointInView(const SE3& T_w_c) {
  const double z = Uniform(2.0, 8.0);
  const double y = Uniform(-0.45, 0.45) * z;
  return T_w_c * Eigen::Vector3d(Uniform(-0.4, 0.6) * z, y, z);
}

Eigen::Vector3d BundleWorldMaker::Start(const Eigen::Vector3d& p_w, const SE3& T_w_c) {
  return p_w + spec_.start_m * (p_w - T_w_c.translation()).norm() * GaussVector();
}

Eigen::Vector3d BundleWorldMaker::Measure(const BundleWorld& world, int pose, const Eigen::Vector3d& p_w,
                                          bool wrong) {
  const StereoCamera& camera = world.problem.camera;
  if (wrong) return {Uniform(0.0, camera.width_px), Uniform(0.0, camera.height_px), Uniform(1.0, 30.0)};
  const Eigen::Vector3d uvd = camera.ProjectStereo(world.true_T_w_c[pose].Inverse() * p_w);
  return uvd + Eigen::Vector3d(spec_.noise_px, spec_.noise_px, spec_.noise_disparity_px).cwiseProduct(GaussVector());
}

void BundleWorldMaker::Measure(const BundleWorld& world, const Segment3& seen_w, bool wrong,
                               LineObservation& observation) {
  const SE3 T_c_w = world.true_T_w_c[observation.pose].Inverse();
  Eigen::Vector3d p = world.problem.camera.ProjectStereo(T_c_w * seen_w.p);
  Eigen::Vector3d q = world.problem.camera.ProjectStereo(T_c_w * seen_w.q);
  if (wrong) {
    p = Measure(world, observation.pose, seen_w.p, true);
    q = Measure(world, observation.pose, seen_w.q, true);
  }
  const Eigen::Vector2d direction = (q - p).head<2>().normalized();
  const Eigen::Vector2d normal(-direction.y(), direction.x());
  observation.observed.p = p.head<2>() + spec_.noise_px * Gauss() * normal;
  observation.observed.q = q.head<2>() + spec_.noise_px * Gauss() * normal;
  observation.disparity_p_px = p.z() + spec_.noise_disparity_px * Gauss();
  observation.disparity_q_px = q.z() + spec_.noise_disparity_px * Gauss();
}

void BundleWorldMaker::MakePoint(BundleWorld& world) {
  const int first = FirstPose(world);
  const Eigen::Vector3d p_w = PointInView(world.true_T_w_c[first]);
  const int index = static_cast<int>(world.true_points.size());
  world.true_points.push_back(p_w);
  world.problem.points.push_back({Start(p_w, world.true_T_w_c[first]), false});
  for (int i = 0; i < spec_.observations; ++i) {
    const bool wrong = Uniform(0.0, 1.0) < spec_.outliers;
    PointObservation observation{first + i, index, Measure(world, first + i, p_w, wrong), 0.0, 0.0};
    if (Uniform(0.0, 1.0) < spec_.without_disparity) observation.uvd.z() = -1.0;
    observation.sigma_px = spec_.noise_px > 0.0 ? spec_.noise_px : kExactSigma_px;
    observation.sigma_disparity_px = spec_.noise_disparity_px > 0.0 ? spec_.noise_disparity_px : kExactSigma_px;
    world.problem.point_observations.push_back(observation);
    world.point_outliers.push_back(wrong);
  }
}

void BundleWorldMaker::MakeLine(BundleWorld& world) {
  const int first = FirstPose(world);
  const SE3& T_w_c = world.true_T_w_c[first];
  const Eigen::Vector3d p_w = PointInView(T_w_c);
  Eigen::Vector3d step = GaussVector();
  if (spec_.upright) step.y() = std::copysign(2.0 + std::abs(step.y()), step.y());
  step *= Uniform(0.5, 1.5) / step.norm();
  const Segment3 segment_w{p_w, p_w + Eigen::Vector3d(step.x(), step.y(), 0.5 * step.z())};
  const int index = static_cast<int>(world.true_lines.size());
  world.true_lines.push_back(segment_w);
  world.problem.lines.push_back({{Start(segment_w.p, T_w_c), Start(segment_w.q, T_w_c)}, false});
  for (int i = 0; i < spec_.observations; ++i) {
    const bool wrong = Uniform(0.0, 1.0) < spec_.outliers;
    const Eigen::Vector3d along = segment_w.q - segment_w.p;
    LineObservation observation;
    observation.pose = first + i;
    observation.line = index;
    const Segment3 seen_w{segment_w.p + Uniform(0.0, 0.3) * along, segment_w.p + Uniform(0.7, 1.0) * along};
    Measure(world, seen_w, wrong, observation);
    if (Uniform(0.0, 1.0) < spec_.without_disparity) observation.disparity_p_px = -1.0;
    observation.sigma_px = spec_.noise_px > 0.0 ? spec_.noise_px : kExactSigma_px;
    observation.sigma_disparity_p_px = spec_.noise_disparity_px > 0.0 ? spec_.noise_disparity_px : kExactSigma_px;
    observation.sigma_disparity_q_px = observation.sigma_disparity_p_px;
    world.problem.line_observations.push_back(observation);
    world.line_outliers.push_back(wrong);
  }
}

BundleWorld BundleWorldMaker::Make() {
  BundleWorld world;
  world.problem.camera = {400.0, 320.0, 240.0, 0.12, 640, 480};
  MakePoses(world);
  for (int i = 0; i < spec_.points; ++i) MakePoint(world);
  for (int i = 0; i < spec_.lines; ++i) MakeLine(world);
  return world;
}

BundleWorld MakeBundleWorld(const BundleWorldSpec& spec, uint32_t seed) {
  return BundleWorldMaker(spec, seed).Make();
}

double DistanceToLine(const Eigen::Vector3d& p, const Segment3& line) {
  return (p - line.p).cross((line.q - line.p).normalized()).norm();
}

BundleErrors ErrorsOf(const BundleWorld& world, const BundleResult& result) {
  BundleErrors sums;
  double poses = 0.0;
  for (size_t i = 0; i < result.T_w_c.size(); ++i) {
    if (world.problem.poses[i].fixed) continue;
    const Vector6d error = ErrorOf(result.T_w_c[i], world.true_T_w_c[i]);
    sums.translation_m += error.head<3>().squaredNorm();
    sums.rotation_rad += error.tail<3>().squaredNorm();
    poses += 1.0;
  }
  for (size_t i = 0; i < result.points.size(); ++i) {
    sums.point_m += (result.points[i] - world.true_points[i]).squaredNorm();
  }
  for (size_t i = 0; i < result.lines.size(); ++i) {
    sums.line_m += std::pow(DistanceToLine(world.true_lines[i].p, result.lines[i]), 2) +
                   std::pow(DistanceToLine(world.true_lines[i].q, result.lines[i]), 2);
  }
  return {RootMean(sums.translation_m, poses), RootMean(sums.rotation_rad, poses),
          RootMean(sums.point_m, static_cast<double>(result.points.size())),
          RootMean(sums.line_m, 2.0 * static_cast<double>(result.lines.size()))};
}

}  // namespace plslam::test
