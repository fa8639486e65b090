// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/similarity.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace plslam {
namespace {

// Share of the largest singular value of the cross covariance below which another is rounding: positions on a line.
constexpr double kRankTolerance = 1e-10;

using Svd = Eigen::JacobiSVD<Eigen::Matrix3d>;

struct Moments {
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();         // a x b
  Eigen::Matrix3d orientations = Eigen::Matrix3d::Zero();  // mean of R_a R_b^T
  double variance_b = 0.0;
};

Moments ComputeMoments(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  Moments m;
  const double n = static_cast<double>(a.size());
  for (size_t i = 0; i < a.size(); ++i) {
    m.mean_b += b[i].translation() / n;
    m.mean_a += a[i].translation() / n;
    m.orientations += a[i].R() * b[i].R().transpose() / n;
  }
  for (size_t i = 0; i < a.size(); ++i) {
    const Eigen::Vector3d e = b[i].translation() - m.mean_b;
    m.cross += (a[i].translation() - m.mean_a) * e.transpose() / n;
    m.variance_b += e.squaredNorm() / n;
  }
  return m;
}

// Flips the last axis if the best orthogonal matrix is a reflection.
Eigen::Vector3d Signs(const Svd& svd) {
  return {1.0, 1.0, svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0};
}

Eigen::Matrix3d NearestRotation(const Svd& svd) {
  return svd.matrixU() * Signs(svd).asDiagonal() * svd.matrixV().transpose();
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m) {
  return NearestRotation(Svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV));
}

// Rotates R about `axis`, which does not move, to agree best with `orientations`: by the angle that maximises
// trace(Turn(angle) * R * orientations^T).
Eigen::Matrix3d TurnToOrientations(const Eigen::Matrix3d& R, const Eigen::Vector3d& axis,
                                   const Eigen::Matrix3d& orientations) {
  const Eigen::Matrix3d B = R * orientations.transpose();
  const double angle = std::atan2((Skew(axis) * B).trace(), B.trace() - axis.dot(B * axis));
  return Eigen::AngleAxisd(angle, axis).toRotationMatrix() * R;
}

}  // namespace

SE3 Similarity::Apply(const SE3& pose) const { return T_a_b * SE3(pose.rotation(), scale * pose.translation()); }

Similarity AlignPaths(const std::vector<SE3>& a, const std::vector<SE3>& b, bool with_scale) {
  if (a.empty()) return {};
  const Moments m = ComputeMoments(a, b);
  const Svd svd(m.cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d& sigma = svd.singularValues();
  // Rounding of positions far from the origin must not count as motion.
  const double extent = 1.0 + m.mean_b.squaredNorm() + m.mean_a.squaredNorm();
  const bool still = sigma[0] <= 1e-24 * extent;
  Eigen::Matrix3d R = NearestRotation(svd);
  if (still) {
    R = NearestRotation(m.orientations);
  } else if (sigma[1] <= kRankTolerance * sigma[0]) {
    R = TurnToOrientations(R, svd.matrixU().col(0), m.orientations);
  }
  Similarity result;
  if (with_scale && !still) result.scale = sigma.dot(Signs(svd)) / m.variance_b;
  result.T_a_b = SE3(R, m.mean_a - result.scale * R * m.mean_b);
  return result;
}

Eigen::Quaterniond AlignOrientations(const std::vector<SE3>& a, const std::vector<SE3>& b) {
  if (a.empty()) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(NearestRotation(ComputeMoments(a, b).orientations));
}

}  // namespace plslam
