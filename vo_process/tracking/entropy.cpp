#include "vo_process/tracking/entropy.h"

#include <cmath>
#include <numbers>

#include <Eigen/Eigenvalues>

namespace plslam {
namespace {

constexpr double kReference = 30.0;
// Nearer to zero than this, the quotient is ill conditioned.
constexpr double kClearlyNegative = -5.0;

}  // namespace

std::optional<double> MotionEntropy(const Matrix6d& covariance) {
  if (!covariance.allFinite()) return std::nullopt;
  // Unit diagonal first, so that metres and radians of very different size do not hide each other.
  const Vector6d diagonal = covariance.diagonal();
  if (!(diagonal.minCoeff() > 0.0)) return std::nullopt;
  const Vector6d scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6d correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(correlation, Eigen::EigenvaluesOnly);
  if (!(eigen.eigenvalues().minCoeff() > 1e-14)) return std::nullopt;
  const double log_determinant = eigen.eigenvalues().array().log().sum() + diagonal.array().log().sum();
  return 3.0 * (1.0 + std::log(2.0 * std::numbers::pi)) + 0.5 * log_determinant;
}

std::optional<double> EntropyRatio(const Matrix6d& covariance_first, const Matrix6d& covariance_now) {
  const std::optional<double> first = MotionEntropy(covariance_first);
  const std::optional<double> now = MotionEntropy(covariance_now);
  if (!first || !now) return std::nullopt;
  if (*first < kClearlyNegative) return *now / *first;
  return 1.0 - (*now - *first) / kReference;
}

}  // namespace plslam
