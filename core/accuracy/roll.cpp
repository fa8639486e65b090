// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/roll.h"

#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

namespace plslam {
namespace {

// Share of the variance along a line below which the variance across it is rounding.
constexpr double kStraight = 1e-10;
/// A standard deviation of a radian is no knowledge of an angle.
constexpr double kUnknownRoll_deg = 57.0;

}  // namespace

double RollSigma_rad(const std::vector<SE3>& truth, double ate_m) {
  const auto n = static_cast<double>(truth.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SE3& pose : truth) mean += pose.translation() / n;
  Eigen::Matrix3d scatter_m2 = Eigen::Matrix3d::Zero();
  for (const SE3& pose : truth) {
    const Eigen::Vector3d p = pose.translation() - mean;
    scatter_m2 += p * p.transpose() / n;
  }
  // Ascending.
  const Eigen::Vector3d variances_m2 =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter_m2, Eigen::EigenvaluesOnly).eigenvalues();
  const double from_line_m2 = variances_m2[0] + variances_m2[1];
  if (from_line_m2 <= kStraight * variances_m2[2]) return std::numbers::pi / 2.0;
  return std::atan2(ate_m, std::sqrt(from_line_m2));
}

std::string RollText(double sigma_deg) {
  return sigma_deg < kUnknownRoll_deg ? fmt::format("positions determine it to {:.1f} deg about the path", sigma_deg)
                                      : "positions do not determine it about the path";
}

}  // namespace plslam
