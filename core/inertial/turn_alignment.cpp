// SPDX-License-Identifier: BSD-3-Clause
#include "core/inertial/turn_alignment.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/se3.h"

namespace plslam {
namespace {

// Step of the grid of delays, and the number of its points.
constexpr int64_t kStep_ns = 10'000'000;
constexpr int kHalf = 30;
constexpr size_t kLags = 2 * kHalf + 1;
static_assert(1e-9 * static_cast<double>(kHalf * kStep_ns) > TurnAlignment::kMostDelay_s - 1e-6 &&
              1e-9 * static_cast<double>(kHalf * kStep_ns) < TurnAlignment::kMostDelay_s + 1e-6);
// Times that are kept of the integral: this far apart at least, and for this long before a pending turn.
constexpr int64_t kSpacing_ns = 2'500'000;
constexpr int64_t kKept_ns = 1'500'000'000;
constexpr size_t kMostKept = 2048;
constexpr size_t kMostPending = 256;
constexpr int64_t kLongestTurn_ns = 1'000'000'000;
// Interval above which turns are not small: a rotation differs from the integral of its rates by the order of the square
// of its angle, of which this share counts as sigma.
constexpr int64_t kSmallTurn_ns = 250'000'000;
constexpr double kNotCommuting = 0.1;
// Interval between samples above which the rates in between are unknown.
constexpr int64_t kLongestInterval_ns = 110'000'000;
// Sigma of the bias before anything is known of it.
constexpr double kBias_rad_s = 0.1;
// Twice the negative logarithms of prior probabilities: of degrees, of another unit, of a delay, and of any other rotation.
constexpr double kDegreesPenalty = 40.0;
constexpr double kScalePenalty = 150.0;
constexpr double kDelayPenalty = 20.0;
constexpr double kRotationPenalty = 80.0;
// Difference of probabilities (as before) up to which two hypotheses are about as likely.
constexpr double kRival = 20.0;
constexpr double kFewestPairs = 10.0;
// Bound on how much too large the variances of seen turns are.
constexpr double kLeastVariance = 0.05;
// Stamps beyond are no times, and differences of those within do not overflow.
constexpr int64_t kMostTime_ns = int64_t{1} << 61;

bool IsTime(int64_t t_ns) { return t_ns > -kMostTime_ns && t_ns < kMostTime_ns; }

double ScalePenalty(double scale) {
  return std::abs(scale * kRadPerDeg - 1.0) < 0.2 ? kDegreesPenalty : kScalePenalty;
}

Eigen::Matrix3d BestRotation(const Eigen::Matrix3d& sensed_seen) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(sensed_seen, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  signs.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

}  // namespace

/// All explanations, each at its best scale and delay.
class TurnAlignment::Search {
 public:
  struct Best {
    double cost = std::numeric_limits<double>::infinity();
    double chi2 = 0.0;
    double scale = 1.0;
    size_t lag = kHalf;
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  };

  /// `sensed_variance` is that of sensed turns relative to that of seen ones.
  Search(const TurnAlignment& turns, double sensed_variance)
      : pairs_(turns.pairs_), sensed_variance_(sensed_variance) {
    for (size_t lag = 0; lag < kLags; ++lag) {
      moments_.push_back(turns.At(lag));
      rotations_.push_back(BestRotation(moments_.back().sensed_seen));
    }
  }

  /// Finds the least sum of squares, which gives the variance for costs.
  void Scale(const std::vector<AxisHypothesis>& axes) {
    variance_ = 1.0;
    double least = std::numeric_limits<double>::infinity();
    for (const AxisHypothesis& a : axes) least = std::min(least, LeastChi2(a.matrix));
    for (size_t lag = 0; lag < kLags; ++lag) {
      for (const bool any_scale : {false, true}) {
        const Best best = Explain(lag, rotations_[lag], any_scale);
        least = std::min(least, best.chi2 / Variance(best.scale));
      }
    }
    variance_ = std::max(kLeastVariance, least / (3.0 * pairs_));
  }

  /// Cost of a matrix at one delay.
  Best Explain(size_t lag, const Eigen::Matrix3d& matrix, bool any_scale) const {
    const Moments& m = moments_[lag];
    const double product = matrix.cwiseProduct(m.sensed_seen).sum();
    Best best;
    best.lag = lag;
    best.matrix = matrix;
    if (any_scale && product > 0.0) best.scale = BestScale(m, product);
    // Noise alone has any scale, but the magnitudes of both turns do not agree with it.
    const double magnitudes2 = best.scale * best.scale / std::max(m.ratio2, 1e-300);
    if (magnitudes2 < 0.25 || magnitudes2 > 4.0) best.scale = 1.0;
    best.chi2 = std::max(0.0, m.sensed2 - 2.0 * best.scale * product + best.scale * best.scale * m.seen2);
    best.cost = best.chi2 / (variance_ * Variance(best.scale)) + (any_scale ? ScalePenalty(best.scale) : 0.0) +
                (lag == kHalf ? 0.0 : kDelayPenalty);
    return best;
  }

  /// The best scale and delay of a matrix.
  Best Explain(const Eigen::Matrix3d& matrix) const {
    Best best;
    for (size_t lag = 0; lag < kLags; ++lag) Take(lag, matrix, best);
    return best;
  }
  Best ExplainByAnyRotation() const {
    Best best;
    for (size_t lag = 0; lag < kLags; ++lag) Take(lag, rotations_[lag], best);
    return best;
  }

  /// Variance of the difference of turns at this scale, relative to that of seen ones.
  double Variance(double scale) const { return sensed_variance_ + scale * scale; }
  /// The variance that the best explanation leaves, 1 if the stated ones are right.
  double variance() const { return variance_; }

 private:
  /// Least of (sensed2 - 2 scale product + scale^2 seen2) over (sensed variance + scale^2): the slope of a line through
  /// points with errors in both coordinates (Deming).
  double BestScale(const Moments& m, double product) const {
    const double difference = m.sensed2 - sensed_variance_ * m.seen2;
    const double root = std::sqrt(difference * difference + 4.0 * sensed_variance_ * product * product);
    return (difference + root) / (2.0 * product);
  }

  void Take(size_t lag, const Eigen::Matrix3d& matrix, Best& best) const {
    for (const bool any_scale : {false, true}) {
      const Best other = Explain(lag, matrix, any_scale);
      if (other.cost < best.cost) best = other;
    }
  }
  double LeastChi2(const Eigen::Matrix3d& matrix) const {
    double least = std::numeric_limits<double>::infinity();
    for (size_t lag = 0; lag < kLags; ++lag) {
      for (const bool any_scale : {false, true}) {
        const Best best = Explain(lag, matrix, any_scale);
        least = std::min(least, best.chi2 / Variance(best.scale));
      }
    }
    return least;
  }

  double pairs_ = 0.0;
  double sensed_variance_ = 0.0;
  double variance_ = 1.0;
  std::vector<Moments> moments_;
  std::vector<Eigen::Matrix3d> rotations_;
};

void TurnAlignment::Add(const ImuSample& sample) {
  if (!IsTime(sample.t_ns) || (has_begun_ && sample.t_ns <= now_.t_ns)) return;
  const int64_t dt_ns = has_begun_ ? sample.t_ns - now_.t_ns : 0;
  if (dt_ns > kKept_ns) integral_.clear();
  now_.after_gap = now_.after_gap || !has_begun_ || dt_ns > kLongestInterval_ns;
  if (has_begun_) now_.turn_rad += 0.5e-9 * static_cast<double>(dt_ns) * (last_rate_rad_s_ + sample.rate_rad_s);
  now_.t_ns = sample.t_ns;
  last_rate_rad_s_ = sample.rate_rad_s;
  has_begun_ = true;
  if (integral_.empty() || now_.after_gap || now_.t_ns - integral_.back().t_ns >= kSpacing_ns) {
    integral_.push_back(now_);
    now_.after_gap = false;
  }
  while (!pending_.empty() && now_.t_ns >= pending_.front().to_ns + kHalf * kStep_ns) {
    Compare(pending_.front());
    pending_.pop_front();
  }
  const int64_t needed_ns = (pending_.empty() ? now_.t_ns : std::min(now_.t_ns, pending_.front().from_ns)) - kKept_ns;
  while (!integral_.empty() && (integral_.front().t_ns < needed_ns || integral_.size() > kMostKept)) {
    integral_.pop_front();
  }
}

void TurnAlignment::Add(const SeenTurn& turn) {
  if (!IsTime(turn.from_ns) || !IsTime(turn.to_ns) || turn.to_ns <= turn.from_ns ||
      turn.to_ns - turn.from_ns > kLongestTurn_ns || !(turn.variance_rad2 > 0.0))
    return;
  pending_.push_back(turn);
  if (turn.to_ns - turn.from_ns > kSmallTurn_ns) {
    const double sigma_rad = kNotCommuting * turn.turn_rad.squaredNorm();
    pending_.back().variance_rad2 += sigma_rad * sigma_rad;
  }
  if (pending_.size() > kMostPending) pending_.pop_front();
}

bool TurnAlignment::HasAllSamples(int64_t from_ns, int64_t to_ns) const {
  if (integral_.size() < 2 || integral_.front().t_ns > from_ns || integral_.back().t_ns < to_ns) return false;
  return std::none_of(integral_.begin() + 1, integral_.end(),
                      [&](const Integral& i) { return i.after_gap && i.t_ns > from_ns && i.t_ns < to_ns; });
}

/// The integral is known at `t_ns`.
Eigen::Vector3d TurnAlignment::IntegralAt(int64_t t_ns) const {
  const auto next = std::lower_bound(integral_.begin(), integral_.end(), t_ns,
                                     [](const Integral& i, int64_t t) { return i.t_ns < t; });
  if (next == integral_.begin()) return next->turn_rad;
  const auto before = next - 1;
  const double share = static_cast<double>(t_ns - before->t_ns) / static_cast<double>(next->t_ns - before->t_ns);
  return before->turn_rad + share * (next->turn_rad - before->turn_rad);
}

void TurnAlignment::Compare(const SeenTurn& turn) {
  if (!HasAllSamples(turn.from_ns - kHalf * kStep_ns, turn.to_ns + kHalf * kStep_ns)) return;
  lags_.resize(kLags);
  const double dt_s = 1e-9 * static_cast<double>(turn.to_ns - turn.from_ns);
  const double kept = 1.0 / (1.0 + dt_s / kMemory_s);
  const double weight = 1.0 / turn.variance_rad2;
  for (size_t i = 0; i < kLags; ++i) {
    const int64_t delay_ns = (static_cast<int64_t>(i) - kHalf) * kStep_ns;
    const Eigen::Vector3d sensed = IntegralAt(turn.to_ns + delay_ns) - IntegralAt(turn.from_ns + delay_ns);
    Lag& lag = lags_[i];
    lag.sensed_dt = kept * lag.sensed_dt + weight * dt_s * sensed;
    lag.sensed_seen = kept * lag.sensed_seen + weight * sensed * turn.turn_rad.transpose();
    lag.sensed2 = kept * lag.sensed2 + weight * sensed.squaredNorm();
  }
  dt2_ = kept * dt2_ + weight * dt_s * dt_s;
  seen_dt_ = kept * seen_dt_ + weight * dt_s * turn.turn_rad;
  seen2_ = kept * seen2_ + weight * turn.turn_rad.squaredNorm();
  weighted_dt_ = kept * weighted_dt_ + weight * dt_s;
  pairs_ = kept * pairs_ + 1.0;
}

TurnAlignment::Moments TurnAlignment::At(size_t lag) const {
  const Lag& sums = lags_[lag];
  const double dt2 = dt2_ + 1.0 / (kBias_rad_s * kBias_rad_s);
  return {sums.sensed_seen - sums.sensed_dt * seen_dt_.transpose() / dt2,
          sums.sensed2 - sums.sensed_dt.squaredNorm() / dt2, seen2_ - seen_dt_.squaredNorm() / dt2,
          sums.sensed2 / std::max(seen2_, 1e-300)};
}

TurnFit TurnAlignment::Fit(const std::vector<AxisHypothesis>& axes, double noise_rad_s_sqrt_hz) const {
  TurnFit fit;
  fit.pairs = pairs_;
  if (pairs_ < kFewestPairs || axes.empty()) return fit;
  Search search(*this, noise_rad_s_sqrt_hz * noise_rad_s_sqrt_hz * weighted_dt_ / pairs_);
  search.Scale(axes);
  const double stated = search.Explain(kHalf, axes.front().matrix, false).cost;
  std::vector<double> costs;
  Search::Best best;
  for (size_t i = 0; i <= axes.size(); ++i) {
    Search::Best other = i < axes.size() ? search.Explain(axes[i].matrix) : search.ExplainByAnyRotation();
    other.cost += i < axes.size() ? axes[i].penalty : kRotationPenalty;
    costs.push_back(other.cost);
    if (other.cost >= best.cost) continue;
    best = other;
    fit.axes = i;
  }
  for (size_t i = 0; i < axes.size(); ++i) fit.n_rivals += i != fit.axes && costs[i] < best.cost + kRival ? 1 : 0;
  fit.excitation = std::sqrt(seen2_ / (3.0 * pairs_));
  fit.variation = std::sqrt(std::max(0.0, At(kHalf).seen2) / (3.0 * pairs_));
  fit.matrix = best.matrix;
  fit.scale = best.scale;
  fit.evidence = stated - best.cost;
  fit.bias_rad_s =
      (lags_[best.lag].sensed_dt - best.scale * best.matrix * seen_dt_) / (dt2_ + 1.0 / (kBias_rad_s * kBias_rad_s));
  fit.residual_rad_sqrt_s = std::sqrt(best.chi2 / (3.0 * weighted_dt_));
  if (best.lag == kHalf) return fit;
  fit.delay_s = 1e-9 * static_cast<double>((static_cast<int64_t>(best.lag) - kHalf) * kStep_ns);
  fit.delay_sigma_s = TurnAlignment::kMostDelay_s;
  if (best.lag == 0 || best.lag + 1 == kLags) return fit;
  const bool any_scale = best.scale != 1.0;
  const double before = search.Explain(best.lag - 1, best.matrix, any_scale).chi2;
  const double after = search.Explain(best.lag + 1, best.matrix, any_scale).chi2;
  const double curvature = before - 2.0 * best.chi2 + after;
  if (!(curvature > 0.0)) return fit;
  const double step_s = 1e-9 * static_cast<double>(kStep_ns);
  fit.delay_s += step_s * std::clamp(0.5 * (before - after) / curvature, -1.0, 1.0);
  fit.delay_sigma_s = step_s * std::sqrt(2.0 * search.variance() * search.Variance(best.scale) / curvature);
  return fit;
}

}  // namespace plslam
