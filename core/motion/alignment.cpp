// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/alignment.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>

#include "core/geometry/symmetric.h"

namespace plslam {
namespace {

constexpr double kMinSineOfTriangle = 0.05;
constexpr double kLargestSideRatio = 1.5;

bool SimilarAndOpen(const std::array<Eigen::Vector3d, 3>& b, const std::array<Eigen::Vector3d, 3>& a) {
  for (int i = 0; i < 3; ++i) {
    const double side_b = (b[(i + 1) % 3] - b[i]).norm();
    const double side_a = (a[(i + 1) % 3] - a[i]).norm();
    if (!(std::min(side_a, side_b) * kLargestSideRatio > std::max(side_a, side_b))) return false;
  }
  const Eigen::Vector3d first = b[1] - b[0];
  const Eigen::Vector3d second = b[2] - b[0];
  return first.cross(second).norm() > kMinSineOfTriangle * first.norm() * second.norm();
}

// Rotation closest to M in the Frobenius norm.
Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& M) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) signs.z() = -1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Eigen::Vector3d Direction(const Segment3& s) { return (s.q - s.p).normalized(); }

}  // namespace

std::optional<SE3> AlignPoints(const std::array<Eigen::Vector3d, 3>& b, const std::array<Eigen::Vector3d, 3>& a) {
  if (!SimilarAndOpen(b, a)) return std::nullopt;
  const Eigen::Vector3d mean_b = (b[0] + b[1] + b[2]) / 3.0;
  const Eigen::Vector3d mean_a = (a[0] + a[1] + a[2]) / 3.0;
  Eigen::Matrix3d M = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) M += (a[i] - mean_a) * (b[i] - mean_b).transpose();
  const Eigen::Matrix3d R = NearestRotation(M);
  return SE3(R, mean_a - R * mean_b);
}

std::optional<SE3> AlignLines(const Segment3& first_b, const Segment3& second_b, const Segment3& first_a,
                              const Segment3& second_a, double min_sine) {
  const Eigen::Vector3d d1_b = Direction(first_b);
  const Eigen::Vector3d d2_b = Direction(second_b);
  const Eigen::Vector3d d1_a = Direction(first_a);
  const Eigen::Vector3d d2_a = Direction(second_a);
  const Eigen::Vector3d normal_b = d1_b.cross(d2_b);
  const Eigen::Vector3d normal_a = d1_a.cross(d2_a);
  if (!(normal_b.norm() > min_sine) || !(normal_a.norm() > min_sine)) return std::nullopt;
  const Eigen::Matrix3d R = NearestRotation(d1_a * d1_b.transpose() + d2_a * d2_b.transpose() +
                                            normal_a.normalized() * normal_b.normalized().transpose());
  // Only directions across a line constrain the translation.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  const auto add = [&](const Segment3& b, const Segment3& a, const Eigen::Vector3d& direction) {
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    information += across;
    sum += across * (0.5 * (a.p + a.q) - R * (0.5 * (b.p + b.q)));
  };
  add(first_b, first_a, d1_a);
  add(second_b, second_a, d2_a);
  return SE3(R, SolveSymmetric<3>(information, sum));
}

}  // namespace plslam
