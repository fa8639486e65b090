// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/plan.h"

#include <algorithm>

#include "core/map/vertical.h"

namespace plslam {
namespace {

constexpr double kLeft_pt = 30.0;
constexpr double kRight_pt = 6.0;
constexpr double kBottom_pt = 23.0;
constexpr double kLeastHeight_pt = 110.0;
constexpr double kMostHeight_pt = 230.0;
/// A path that climbs by more than this share of its length or width is seen from the side.
constexpr double kUpright = 0.75;
/// A path is called longer than wide from here on.
constexpr double kLong = 1.3;

Eigen::Vector3d ExtentAlong(const Eigen::Matrix3d& axes, const std::vector<Eigen::Vector3d>& positions) {
  if (positions.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d low = axes.transpose() * positions[0], high = low;
  for (const Eigen::Vector3d& position : positions) {
    const Eigen::Vector3d p = axes.transpose() * position;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return high - low;
}

}  // namespace

std::vector<Eigen::Vector2d> ViewDirections::operator()(const std::vector<Eigen::Vector3d>& path) const {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(path.size());
  for (const Eigen::Vector3d& p : path) flat.push_back((*this)(p));
  return flat;
}

ViewDirections ViewOf(const std::vector<Eigen::Vector3d>& positions, const Eigen::Vector3d& up_w) {
  const Eigen::Matrix3d R_w_level = LevelRotation(up_w).conjugate().toRotationMatrix();
  const Eigen::Vector3d extent = ExtentAlong(R_w_level, positions);
  const Eigen::Vector3d x = R_w_level.col(0), y = R_w_level.col(1), z = R_w_level.col(2);
  const bool level = extent.y() <= kUpright * std::max(extent.x(), extent.z());
  if (!level && extent.x() < extent.z()) return {z, -y, "z [m]", "-y [m]"};
  if (!level) return {x, -y, "x [m]", "-y [m]"};
  if (extent.z() > kLong * extent.x()) return {z, -x, "z [m]", "-x [m]"};
  return {x, z, "x [m]", "z [m]"};
}

Plan PlanAround(const std::vector<Eigen::Vector2d>& positions, double top_pt) {
  constexpr double kMargin = 1.10;
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
  if (!positions.empty()) low = high = positions[0];
  for (const Eigen::Vector2d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector2d extent = (high - low).cwiseMax(1e-3), centre = 0.5 * (low + high);
  const double width = kColumn_pt - kLeft_pt - kRight_pt;
  const double height = std::clamp(width * extent.y() / extent.x(), kLeastHeight_pt, kMostHeight_pt);
  const double m_per_pt = kMargin * std::max(extent.x() / width, extent.y() / height);
  const Eigen::Vector2d half = 0.5 * m_per_pt * Eigen::Vector2d(width, height);
  Plan plan;
  plan.area = {{kLeft_pt, top_pt}, {width, height}};
  plan.x = {centre.x() - half.x(), centre.x() + half.x()};
  plan.y = {centre.y() - half.y(), centre.y() + half.y()};
  plan.height_pt = top_pt + height + kBottom_pt;
  return plan;
}

}  // namespace plslam
