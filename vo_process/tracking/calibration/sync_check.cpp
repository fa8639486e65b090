// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/sync_check.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "vo_process/stereo/row_field.h"
#include "vo_process/tracking/calibration/row_calibration.h"

namespace plslam::vo {
namespace {

// Vertical motion between frames of the points that a frame must have to be informative, and their least number.
constexpr double kMinFlow_px = 1.0;
constexpr int kMinMoving = 20;
// Prior sigmas: of the mean of the rows, of the shape of the field, and, in frames, of lateness and unevenness.
constexpr double kShiftSigma_px = 5.0;
constexpr double kShapeSigma_px = 1.0;
constexpr double kLateSigma_frames = 1.0;
constexpr double kUnevenSigma_frames = 0.1;
// Factor of past equations at each frame: a memory of some fifty frames.
constexpr double kMemory = 0.98;
// Matches searched with another lateness are biased towards it: if the new estimate differs significantly, and moves
// rows by enough to matter to the search, past equations are reduced by this factor.
constexpr double kOtherRows_px = 1.0;
constexpr double kOtherDeviations = 3.0;
constexpr double kMemoryOfOthers = 0.1;
// Residuals below expectation reduce the sigmas, but not below this share. Residuals above it come from wrong matches,
// which are frequent while matches are searched in the wrong rows.
constexpr double kMinNoise = 0.3;
constexpr int kIterations = 3;
// Errors common to tracks, as of corners that slide along edges, do not average out over few points: variances are
// multiplied by 1 + this / points.
constexpr double kErrorsInCommon = 60.0;
// Conditions to apply the estimate: standard deviations, frames, and a share of the time between frames; a smaller
// share to keep it.
constexpr double kMinDeviations = 10.0;
constexpr int64_t kMinFrames = 3;
constexpr double kMinLate_frames = 0.05;
// The same for the delay that motions show: while driving straight ahead, grazing ground looks like a small one.
constexpr double kMinDeviationsOfMotion = 20.0;
constexpr double kMinLateByMotion_frames = 0.07;
constexpr double kMinLateOfUsed_frames = 0.03;
// Longest time over which motions are extrapolated, in frames.
constexpr double kMaxLate_frames = 1.5;
constexpr double kMinUneven_frames = 0.05;

}  // namespace

PairSkew SyncCheck::SkewOf(const SE3& T_prev_c, double dt_s) const {
  if (late_s() == 0.0 || !(dt_s > 0.0)) return {};
  const double frames = std::clamp(late_s() / dt_s, -kMaxLate_frames, kMaxLate_frames);
  return {camera_, SE3::Exp(-frames * T_prev_c.Log())};
}

const SyncCheck::Seen* SyncCheck::FindSeen(TrackId landmark_id) const {
  const auto before = [](const Seen& s, TrackId id) { return s.landmark_id < id; };
  const auto found = std::lower_bound(seen_.begin(), seen_.end(), landmark_id, before);
  return found == seen_.end() || found->landmark_id != landmark_id ? nullptr : &*found;
}

bool SyncCheck::Observe(const TrackedFrame& frame, double dt_s,
                        const std::optional<TimingCheck::Estimate>& by_motion) {
  const std::vector<Equation> equations = EquationsOf(frame, dt_s);
  Remember(frame, dt_s);
  const bool was_late = late_s() != 0.0;
  const auto moves = [dt_s](const Equation& e) { return std::abs(e.terms(kLate)) * dt_s > kMinFlow_px; };
  if (std::count_if(equations.begin(), equations.end(), moves) >= kMinMoving) {
    Learn(equations, dt_s);
    Decide(equations, dt_s);
  }
  if (by_motion) UseMotion(*by_motion, dt_s);
  return (late_s() != 0.0) != was_late;
}

// Poses in doubt show no exact motion, so only delays that can be compensated are taken from it. The measure that is
// significant first remains in use: rows where corners are many, motions where they are few and rows mislead.
void SyncCheck::UseMotion(const TimingCheck::Estimate& by_motion, double dt_s) {
  if (is_late_ && !is_late_by_motion_) return;
  const double frames = std::abs(by_motion.value) / dt_s;
  const bool is_significant =
      is_late_by_motion_ ? frames > kMinLateOfUsed_frames
                         : frames > kMinLateByMotion_frames && by_motion.DiffersFrom(0.0, kMinDeviationsOfMotion);
  is_late_by_motion_ = is_significant && frames < kLargestCompensatedDelay_frames;
  late_by_motion_s_ = by_motion.value;
  if (is_late_by_motion_) interval_s_ = dt_s;
}

// With a changing motion, the velocity at the time of the left image is between those before and after it, and at the
// time of the next frame that after it.
std::vector<SyncCheck::Equation> SyncCheck::EquationsOf(const TrackedFrame& frame, double dt_s) const {
  std::vector<Equation> equations;
  const double along = std::clamp(solution_(kLate) / dt_s, -1.0, 1.0);
  for (size_t i = 0; i < frame.point_tracks.size(); ++i) {
    const Seen* seen = FindSeen(frame.point_tracks[i].landmark_id);
    if (seen == nullptr || !seen->has_moved || seen->variance_px2 == 0.0) continue;
    const double after_px_s = (frame.features.points[i].left.px.y() - seen->px.y()) / dt_s;
    const double down_px_s = 0.5 * ((1.0 + along) * after_px_s + (1.0 - along) * seen->down_px_s);
    Equation& equation = equations.emplace_back();
    equation.terms << RowField::Terms(camera_, seen->place_px), down_px_s,
        2.0 * (seen->px.y() - camera_.cy_px) / camera_.height_px * down_px_s;
    equation.offset_px = seen->offset_px;
    equation.variance_px2 = seen->variance_px2;
    equation.sharing = seen->sharing;
  }
  return equations;
}

void SyncCheck::Learn(const std::vector<Equation>& equations, double dt_s) {
  if (n_frames_ == 0) {
    Vector8d sigmas;
    sigmas << kShiftSigma_px, Eigen::Matrix<double, 5, 1>::Constant(kShapeSigma_px), kLateSigma_frames * dt_s,
        kUnevenSigma_frames * dt_s;
    information_ = sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
  }
  ++n_frames_;
  interval_s_ = dt_s;
  const Matrix8d before = kMemory * information_;
  const Vector8d vector_before = kMemory * vector_;
  double squares = 0.0;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    information_ = before;
    vector_ = vector_before;
    squares = 0.0;
    for (const Equation& e : equations) {
      const double deviation = std::abs(e.offset_px - e.terms.dot(solution_)) / std::sqrt(e.variance_px2);
      const double factor = RowHuberFactor(deviation);
      const Vector8d weighted = e.terms / (e.variance_px2 * e.sharing * factor);
      information_ += weighted * e.terms.transpose();
      vector_ += e.offset_px * weighted;
      squares += deviation * deviation / factor;
    }
    solution_ = information_.ldlt().solve(vector_);
  }
  squares_ = kMemory * squares_ + squares;
  count_ = kMemory * count_ + static_cast<double>(equations.size());
}

void SyncCheck::Decide(const std::vector<Equation>& equations, double dt_s) {
  const double noise = std::clamp(std::sqrt(squares_ / count_), kMinNoise, 1.0);
  const double frames = (1.0 - std::pow(kMemory, n_frames_)) / (1.0 - kMemory);
  const double in_common = std::sqrt(1.0 + kErrorsInCommon * frames / count_);
  const Vector8d sigmas =
      noise * in_common * information_.ldlt().solve(Matrix8d::Identity()).diagonal().cwiseMax(0.0).cwiseSqrt();
  const auto is_significant = [&](int i, double least_frames) {
    return n_frames_ >= kMinFrames && std::abs(solution_(i)) > least_frames * dt_s &&
           std::abs(solution_(i)) > kMinDeviations * sigmas(i);
  };
  is_late_ =
      is_late_ ? std::abs(solution_(kLate)) > kMinLateOfUsed_frames * dt_s : is_significant(kLate, kMinLate_frames);
  is_uneven_ = is_significant(kUneven, kMinUneven_frames);
  double square_px_s = 0.0;
  for (const Equation& e : equations) square_px_s += e.terms(kLate) * e.terms(kLate);
  const double down_px_s = std::sqrt(square_px_s / static_cast<double>(equations.size()));
  const double other_s = std::abs(late_s() - late_matched_s_);
  if (other_s * down_px_s > kOtherRows_px && other_s > kOtherDeviations * sigmas(kLate)) {
    information_ *= kMemoryOfOthers;
    vector_ *= kMemoryOfOthers;
    late_matched_s_ = late_s();
  }
}

void SyncCheck::Remember(const TrackedFrame& frame, double dt_s) {
  std::vector<Seen> now;
  std::vector<size_t> place_of(frame.point_tracks.size(), frame.point_tracks.size());
  for (size_t i = 0; i < frame.point_tracks.size(); ++i) {
    const TrackId id = frame.point_tracks[i].landmark_id;
    if (id < 0) continue;
    place_of[i] = now.size();
    Seen& seen = now.emplace_back();
    seen.landmark_id = id;
    seen.px = frame.features.points[i].left.px;
    if (const Seen* before = FindSeen(id)) {
      seen.down_px_s = (seen.px.y() - before->px.y()) / dt_s;
      seen.has_moved = true;
    }
  }
  for (const RowObservation& o : RowObservationsOf(frame.features, camera_)) {
    if (place_of[o.point] == frame.point_tracks.size()) continue;
    Seen& seen = now[place_of[o.point]];
    seen.place_px = o.place_px;
    seen.offset_px = o.offset_px;
    seen.variance_px2 = o.variance_px2;
    seen.sharing = o.sharing;
  }
  std::sort(now.begin(), now.end(), [](const Seen& a, const Seen& b) { return a.landmark_id < b.landmark_id; });
  seen_ = std::move(now);
}

}  // namespace plslam::vo
