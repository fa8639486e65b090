// SPDX-License-Identifier: BSD-3-Clause
#include "core/accuracy/consistency.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Cholesky>

namespace plslam {

Statistics Summarise(std::vector<double> values) {
  Statistics result;
  if (values.empty()) return result;
  double sum = 0.0;
  double sum_of_squares = 0.0;
  for (const double value : values) {
    sum += value;
    sum_of_squares += value * value;
  }
  std::sort(values.begin(), values.end());
  const size_t n = values.size();
  result.n = static_cast<int>(n);
  result.rmse = std::sqrt(sum_of_squares / static_cast<double>(n));
  result.mean = sum / static_cast<double>(n);
  result.median = 0.5 * (values[(n - 1) / 2] + values[n / 2]);
  result.max = values.back();
  return result;
}

double ChiSquareQuantile(double degrees_of_freedom, double z) {
  const double k = 2.0 / (9.0 * degrees_of_freedom);
  return degrees_of_freedom * std::pow(1.0 - k + z * std::sqrt(k), 3);
}

namespace {

constexpr double kZ95 = 1.959964;
constexpr double kQuantile95Of6 = 12.591587;

const Matrix6d* Find(const std::vector<PoseCovariance>& covariances, int64_t t_ns) {
  const auto found = std::lower_bound(covariances.begin(), covariances.end(), t_ns,
                                      [](const PoseCovariance& row, int64_t t) { return row.t_ns < t; });
  return found != covariances.end() && found->t_ns == t_ns ? &found->covariance : nullptr;
}

// Returns nullopt if the covariance is not positive definite. Scales to unit variances first, because those of metres
// and of radians differ by orders of magnitude.
std::optional<double> Nees(const Vector6d& x, const Matrix6d& covariance) {
  if (!(covariance.diagonal().minCoeff() > 0.0)) return std::nullopt;
  const Vector6d scale = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix6d correlation = scale.asDiagonal() * covariance * scale.asDiagonal();
  const Eigen::LLT<Matrix6d> llt(correlation);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const double nees = llt.matrixL().solve(scale.cwiseProduct(x)).squaredNorm();
  return std::isfinite(nees) ? std::optional(nees) : std::nullopt;
}

// Covariance of the motion between two pairs; nullopt if a frame between them has no pose or no covariance.
std::optional<Matrix6d> CovarianceOver(const PosePairs& pairs, size_t first, size_t last,
                                       const std::vector<PoseCovariance>& covariances) {
  Matrix6d sum = Matrix6d::Zero();
  for (size_t i = first + 1; i <= last; ++i) {
    const Matrix6d* covariance = Find(covariances, pairs[i].t_ns);
    if (covariance == nullptr || pairs[i].estimate_index != pairs[i - 1].estimate_index + 1) return std::nullopt;
    sum = ComposeCovariance(sum, pairs[i - 1].estimate.Inverse() * pairs[i].estimate, *covariance);
  }
  return sum;
}

class Collector {
 public:
  // `error` takes the true motion to the estimated one: T_true = T * Exp(x) is T^-1 T_true = error^-1.
  void Add(const SE3& error, const Matrix6d& covariance) {
    const std::optional<double> nees = Nees(error.Inverse().Log(), covariance);
    if (nees) {
      values_.push_back(*nees);
    } else {
      ++result_.singular;
    }
  }

  // `shared`: number of samples that share data, and count as one for the bounds.
  Consistency Result(size_t shared = 1) {
    result_.n = static_cast<int>(values_.size());
    if (values_.empty()) return result_;
    const double n = static_cast<double>(values_.size());
    const double independent = std::max(1.0, n / static_cast<double>(shared));
    const auto above = std::count_if(values_.begin(), values_.end(), [](double v) { return v > kQuantile95Of6; });
    result_.above_95_percent = 100.0 * static_cast<double>(above) / n;
    result_.mean_nees = Summarise(values_).mean;
    result_.lower_bound = ChiSquareQuantile(6.0 * independent, -kZ95) / independent;
    result_.upper_bound = ChiSquareQuantile(6.0 * independent, kZ95) / independent;
    return result_;
  }

 private:
  std::vector<double> values_;
  Consistency result_;
};

}  // namespace

Consistency PoseConsistency(const PosePairs& pairs, const std::vector<PoseCovariance>& covariances) {
  Collector collector;
  const PosePair* first = nullptr;
  const Matrix6d* first_covariance = nullptr;
  for (const PosePair& pair : pairs) {
    const Matrix6d* covariance = Find(covariances, pair.t_ns);
    if (covariance == nullptr) continue;
    if (first == nullptr) {
      first = &pair;
      first_covariance = covariance;
      continue;
    }
    const SE3 T_first_pair = first->estimate.Inverse() * pair.estimate;
    const Matrix6d carried = ComposeCovariance(*first_covariance, T_first_pair, Matrix6d::Zero());
    collector.Add(MotionError(*first, pair), *covariance - carried);
  }
  return collector.Result();
}

Consistency MotionConsistency(const PosePairs& pairs, const std::vector<PoseCovariance>& covariances, size_t span) {
  Collector collector;
  for (size_t i = span; i < pairs.size(); ++i) {
    if (const auto covariance = CovarianceOver(pairs, i - span, i, covariances)) {
      collector.Add(MotionError(pairs[i - span], pairs[i]), *covariance);
    }
  }
  return collector.Result(span);
}

}  // namespace plslam
