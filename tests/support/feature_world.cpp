// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/feature_world.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace plslam::test {
namespace {

constexpr double kMinDepth_m = 0.3;
constexpr double kMinLength_px = 20.0;

class Noise {
 public:
  Noise(double sigma, uint64_t seed) : sigma_(sigma), generator_(seed) {}
  double operator()() { return sigma_ * normal_(generator_); }

 private:
  double sigma_;
  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
};

Descriptor RandomDescriptor(std::mt19937_64& generator) {
  return {generator(), generator(), generator(), generator()};
}

/// One draw after the other: arguments of a function are evaluated in an order that each compiler chooses.
template <class Draw>
Eigen::Vector3d Drawn(Draw& draw) {
  const double z = draw();
  const double y = draw();
  return {draw(), y, z};
}

Eigen::Vector3d RandomInShell(std::mt19937_64& generator) {
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(generator); };
  std::uniform_real_distribution<double> radius(2.0, 8.0);
  const Eigen::Vector3d direction = Drawn(draw);
  return radius(generator) * direction.normalized();
}

}  // namespace

FeatureWorld::FeatureWorld(const Counts& counts, uint64_t seed) {
  std::mt19937_64 generator(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&] { return normal(generator); };
  // Only part of a shell is in view: make enough that about `counts` are.
  for (int i = 0; i < 6 * counts.points; ++i) {
    const Eigen::Vector3d p = RandomInShell(generator);
    points_.push_back({p, RandomDescriptor(generator)});
  }
  for (int i = 0; i < 6 * counts.lines; ++i) {
    const Eigen::Vector3d p = RandomInShell(generator);
    const Eigen::Vector3d along = Drawn(draw);
    lines_.push_back({{p, p + along.normalized()}, RandomDescriptor(generator)});
  }
}

FeatureWorld::FeatureWorld(std::vector<Point> points, std::vector<Line> lines, double max_depth_m)
    : points_(std::move(points)), lines_(std::move(lines)), max_depth_m_(max_depth_m) {}

StereoFeatures FeatureWorld::Observe(const SE3& T_w_c, double noise_px, uint64_t seed) const {
  const StereoCamera camera = Camera();
  const SE3 T_c_w = T_w_c.Inverse();
  Noise noise(noise_px, seed);
  const double sigma = std::max(noise_px, 0.1);
  StereoFeatures features;
  for (const Point& point : points_) {
    const Eigen::Vector3d p_c = T_c_w * point.p_w;
    if (p_c.z() < kMinDepth_m || p_c.z() > max_depth_m_) continue;
    if (!camera.InImage(camera.Project(p_c), 5.0)) continue;
    const Eigen::Vector3d uvd = camera.ProjectStereo(p_c) + Drawn(noise);
    StereoPoint seen;
    seen.left.px = uvd.head<2>();
    seen.left.descriptor = point.descriptor;
    seen.disparity_px = uvd.z();
    seen.sigma_px = seen.sigma_disparity_px = sigma;
    features.points.push_back(seen);
  }
  for (const Line& line : lines_) {
    const Eigen::Vector3d p_c = T_c_w * line.segment_w.p;
    const Eigen::Vector3d q_c = T_c_w * line.segment_w.q;
    if (p_c.z() < kMinDepth_m || q_c.z() < kMinDepth_m) continue;
    if (p_c.z() > max_depth_m_ || q_c.z() > max_depth_m_) continue;
    if (!camera.InImage(camera.Project(p_c), 5.0) || !camera.InImage(camera.Project(q_c), 5.0)) continue;
    const Eigen::Vector3d p = camera.ProjectStereo(p_c) + Drawn(noise);
    const Eigen::Vector3d q = camera.ProjectStereo(q_c) + Drawn(noise);
    StereoLine seen;
    seen.left.segment = {p.head<2>(), q.head<2>()};
    if (seen.left.segment.Length() < kMinLength_px) continue;
    seen.left.descriptor = line.descriptor;
    seen.sigma_px = seen.sigma_disparity_p_px = seen.sigma_disparity_q_px = sigma;
    // As in a front end: no depth for lines along the baseline.
    const Eigen::Vector2d along = seen.left.segment.q - seen.left.segment.p;
    if (std::abs(along.y()) > 0.2 * along.norm()) {
      seen.disparity_p_px = p.z();
      seen.disparity_q_px = q.z();
    }
    features.lines.push_back(seen);
  }
  return features;
}

}  // namespace plslam::test
