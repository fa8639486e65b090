// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/timing_check.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "core/geometry/hypot.h"
#include "vo_process/tracking/calibration/disparity_check.h"

namespace plslam::vo {
namespace {

// Frames from the first to the second one of a pair: enough for parallax, and most features are still seen.
constexpr int64_t kFramesApart = 5;
// Fewest equations of a pair of frames, for 12 unknowns.
constexpr double kMinEquations = 60.0;
constexpr int kIterations = 4;
// Norm of the whitened residuals of a point or of both residuals of an end.
constexpr double kHuber = 2.0;
constexpr double kMaxDeviation = 6.0;
// Before large effects are estimated, all features deviate.
constexpr int kRejectingIterations = 2;
// Points whose patch measures its row independently; others slide along edges.
constexpr double kMaxSigmaRow_px = 0.4;
// Segments are compared across their direction; a steeper one determines its column in the right image.
constexpr double kMinSine = 0.2;
// Prior sigmas: lateness and readout in frames, and b0 in pixels.
constexpr double kLateSigma_frames = 1.0;
constexpr double kReadoutSigma_frames = 1.0;
constexpr double kOffsetSigma_px = 0.5;
// Factor of past evidence at each pair: a memory of some thirty pairs.
constexpr double kMemory = 0.97;
// Residuals above expectation increase sigmas; those below reduce them at most by this factor.
constexpr double kMinNoise = 0.7;
// Pairs before the first estimate: two in one half, since each may mislead.
constexpr int64_t kMinPairs = 3;
// Halves differ if their difference exceeds so many of its sigmas.
constexpr double kDifferSigmas = 3.0;

template <class Seen>
const Seen* Find(const std::vector<Seen>& seen, TrackId id) {
  const auto before = [](const Seen& s, TrackId of) { return s.landmark_id < of; };
  const auto found = std::lower_bound(seen.begin(), seen.end(), id, before);
  return found == seen.end() || found->landmark_id != id ? nullptr : &*found;
}

template <class Seen>
void SortByLandmark(std::vector<Seen>& seen) {
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.landmark_id < b.landmark_id; });
}

/// Derivative of `Backproject`.
Eigen::Matrix3d BackprojectJacobian(const StereoCamera& camera, const Eigen::Vector3d& p_c, double disparity_px) {
  const double per_px = p_c.z() / camera.f_px;
  Eigen::Matrix3d J;
  J << per_px, 0.0, -p_c.x() / disparity_px,  //
      0.0, per_px, -p_c.y() / disparity_px,   //
      0.0, 0.0, -p_c.z() / disparity_px;
  return J;
}

Eigen::Vector2d UnitNormal(const Eigen::Vector2d& direction) {
  return Eigen::Vector2d(-direction.y(), direction.x()).normalized();
}

}  // namespace

struct TimingCheck::Sum {
  Normal normal = Normal::Zero();
  double squares = 0.0;
  double count = 0.0;
  double max_deviation = 0.0;

  /// Adds whitened residuals: `delta` is predicted minus measured, with its derivatives by parameters and motion.
  template <int N>
  void Add(const Eigen::Matrix<double, N, 1>& delta, const Eigen::Matrix<double, N, 6>& by_parameters,
           const Eigen::Matrix<double, N, 6>& by_motion, const Eigen::Matrix<double, N, N>& covariance) {
    const Eigen::LLT<Eigen::Matrix<double, N, N>> llt(covariance);
    const Eigen::Matrix<double, N, 1> r = llt.matrixL().solve(delta);
    const double deviation = r.norm();
    if (!(deviation < max_deviation)) return;
    Eigen::Matrix<double, N, 12> by_all;
    by_all << by_parameters, by_motion;
    by_all = llt.matrixL().solve(by_all);
    const double weight = 1.0 / std::max(1.0, deviation / kHuber);
    normal.leftCols<12>() += weight * by_all.transpose() * by_all;
    normal.col(12) -= weight * by_all.transpose() * r;
    squares += weight * r.squaredNorm();
    count += N;
  }
};

/// Sets the effects; `along` is the direction of a segment in the right image, or null for a point.
TimingCheck::Place TimingCheck::PlaceOf(const Eigen::Vector3d& uvd, const Vector6d& velocity,
                                        const Eigen::Vector2d* along) const {
  Place place;
  place.uvd = uvd;
  const Eigen::Vector3d p_c = camera_.Backproject(uvd);
  const Eigen::Vector3d moves = -(velocity.head<3>() + velocity.tail<3>().cross(p_c));
  const double per_m = camera_.f_px / p_c.z();
  const Eigen::Vector2d ray(p_c.x() / p_c.z(), p_c.y() / p_c.z());
  const Eigen::Vector2d left_px_s = per_m * (moves.head<2>() - ray * moves.z());
  const Eigen::Vector2d right_px_s =
      left_px_s + Eigen::Vector2d(per_m * camera_.baseline_m / p_c.z() * moves.z(), 0.0);
  // A right segment that moves down by dv crosses a row dv * (direction.x / direction.y) further left.
  const double column_px_s =
      along == nullptr ? right_px_s.x() : right_px_s.x() - right_px_s.y() * along->x() / along->y();
  place.by_late_px_s = -column_px_s;
  const RowShares shares = shutter_.SharesOf(uvd.head<2>(), uvd.z());
  const auto by_readout = [&shares](const Eigen::Vector2d& left, double right_u) {
    return Eigen::Vector3d(shares.left * left.x(), shares.left * left.y(),
                           shares.left * left.x() - shares.right * right_u);
  };
  // Both cameras see the same flow of a turn around the left one, but for its small motion in depth.
  const Eigen::Vector3d turns = -velocity.tail<3>().cross(p_c);
  const Eigen::Vector2d turning_px_s = per_m * (turns.head<2>() - ray * turns.z());
  const double turning_right_px_s = turning_px_s.x() + per_m * camera_.baseline_m / p_c.z() * turns.z();
  place.by_turning_px_s = by_readout(turning_px_s, turning_right_px_s);
  place.by_translation_px_s = by_readout(left_px_s - turning_px_s, right_px_s.x() - turning_right_px_s);
  return place;
}

/// Derivatives of (u, v, disparity) as measured by the parameters.
TimingCheck::Effects TimingCheck::EffectsOn(const Place& place) const {
  Effects effects = Effects::Zero();
  effects(2, kLate) = place.by_late_px_s;
  effects.col(kReadoutOfTurning) = place.by_turning_px_s;
  effects.col(kReadoutOfTranslation) = place.by_translation_px_s;
  effects.block<1, 3>(2, kOffset) = DisparityErrorTerms(camera_, place.uvd.x()).transpose();
  return effects;
}

TimingCheck::View TimingCheck::ViewOf(const TrackedFrame& frame, const SE3& T_odom_c, const Vector6d& velocity,
                                      const Parameters& applied) const {
  View view;
  view.T_odom_c = T_odom_c;
  view.applied = applied;
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    const StereoPoint& point = frame.features.points[i];
    const FeatureTrack& track = frame.point_tracks[i];
    const bool is_corner = point.sigma_row_px >= 0.0 && point.sigma_row_px < kMaxSigmaRow_px;
    if (track.landmark_id < 0 || !track.IsOfWorld() || !point.HasDepth() || !is_corner) continue;
    Point& seen = view.points.emplace_back();
    seen.landmark_id = track.landmark_id;
    seen.at = PlaceOf({point.left.px.x(), point.left.px.y(), point.disparity_px}, velocity, nullptr);
    seen.at.sigma_px = point.sigma_px;
    seen.at.sigma_disparity_px = point.sigma_disparity_px;
  }
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    const StereoLine& line = frame.features.lines[i];
    const FeatureTrack& track = frame.line_tracks[i];
    if (track.landmark_id < 0 || !track.IsOfWorld() || !line.HasDepth()) continue;
    const Segment2& s = line.left.segment;
    const Eigen::Vector2d along = s.q - s.p - Eigen::Vector2d(line.disparity_q_px - line.disparity_p_px, 0.0);
    if (!(std::abs(along.y()) > kMinSine * along.norm())) continue;
    Line& seen = view.lines.emplace_back();
    seen.landmark_id = track.landmark_id;
    seen.p = PlaceOf({s.p.x(), s.p.y(), line.disparity_p_px}, velocity, &along);
    seen.q = PlaceOf({s.q.x(), s.q.y(), line.disparity_q_px}, velocity, &along);
    seen.p.sigma_px = seen.q.sigma_px = line.sigma_px;
    seen.p.sigma_disparity_px = line.sigma_disparity_p_px;
    seen.q.sigma_disparity_px = line.sigma_disparity_q_px;
  }
  SortByLandmark(view.points);
  SortByLandmark(view.lines);
  return view;
}

void TimingCheck::Observe(const TrackedFrame& frame, const SE3& T_odom_c, const Vector6d& velocity,
                          const Parameters& applied, double dt_s) {
  if (!shutter_.can_be_measured()) return;
  if (begin_.n_frames > 0 && begin_.n_frames++ < kFramesApart) return;
  dt_s_ = dt_s;
  View now = ViewOf(frame, T_odom_c, velocity, applied);
  if (begin_.n_frames == 0) {
    begin_ = std::move(now);
    begin_.n_frames = 1;
    return;
  }
  Learn(now);
  Interrupt();
}

/// Adds the residuals of all features that both views of the pair have.
void TimingCheck::Add(const View& now, const SE3& T_now_before, const Parameters& parameters, Sum& sum) const {
  struct Predicted {
    bool is_valid = false;
    Eigen::Vector3d uvd;
    Eigen::Matrix3d covariance;
    Effects by_parameters;
    Eigen::Matrix<double, 3, 6> by_motion;
  };
  const Eigen::Matrix3d R = T_now_before.R();
  // Parameters relative to those with which the features of a frame are already corrected.
  const Parameters rest_before = parameters - begin_.applied;
  const Parameters rest_now = parameters - now.applied;
  const auto predict = [&](const Place& before) {
    Predicted predicted;
    const Effects effects = EffectsOn(before);
    const Eigen::Vector3d uvd = before.uvd - effects * rest_before;
    if (!(uvd.z() > 0.1)) return predicted;
    const Eigen::Vector3d p_before = camera_.Backproject(uvd);
    const Eigen::Vector3d p_now = T_now_before * p_before;
    if (!(p_now.z() > camera_.MinDepth())) return predicted;
    const Eigen::Matrix3d by_p_before = camera_.ProjectStereoJacobian(p_now) * R;
    const Eigen::Matrix3d by_uvd = by_p_before * BackprojectJacobian(camera_, p_before, uvd.z());
    const Eigen::Vector3d variances(before.sigma_px * before.sigma_px, before.sigma_px * before.sigma_px,
                                    before.sigma_disparity_px * before.sigma_disparity_px);
    predicted.is_valid = true;
    predicted.uvd = camera_.ProjectStereo(p_now);
    predicted.covariance = by_uvd * variances.asDiagonal() * by_uvd.transpose();
    predicted.by_parameters = -by_uvd * effects;
    predicted.by_motion << by_p_before, -by_p_before * Skew(p_before);
    return predicted;
  };
  const auto variances_of = [](const Place& place) {
    return Eigen::Vector3d(place.sigma_px * place.sigma_px, place.sigma_px * place.sigma_px,
                           place.sigma_disparity_px * place.sigma_disparity_px);
  };
  for (const Point& point : now.points) {
    const Point* before = Find(begin_.points, point.landmark_id);
    if (before == nullptr) continue;
    const Predicted predicted = predict(before->at);
    if (!predicted.is_valid) continue;
    const Eigen::Matrix3d covariance = predicted.covariance + Eigen::Matrix3d(variances_of(point.at).asDiagonal());
    const Effects effects = EffectsOn(point.at);
    sum.Add<3>(predicted.uvd - (point.at.uvd - effects * rest_now), predicted.by_parameters + effects,
               predicted.by_motion, covariance);
  }
  for (const Line& line : now.lines) {
    const Line* before = Find(begin_.lines, line.landmark_id);
    if (before == nullptr) continue;
    const Eigen::Vector2d along = line.q.uvd.head<2>() - line.p.uvd.head<2>();
    const Eigen::Vector2d left = UnitNormal(along);
    const Eigen::Vector2d right = UnitNormal(along - Eigen::Vector2d(line.q.uvd.z() - line.p.uvd.z(), 0.0));
    Eigen::Matrix<double, 2, 3> across;
    across << left.x(), left.y(), 0.0, right.x(), right.y(), -right.x();
    for (const Place* end : {&before->p, &before->q}) {
      const Predicted predicted = predict(*end);
      if (!predicted.is_valid) continue;
      // Pieces of an edge that do not overlap say little about each other.
      const double t = (predicted.uvd - line.p.uvd).head<2>().dot(along) / along.squaredNorm();
      if (!(t > -0.5 && t < 1.5)) continue;
      const Effects effects = (1.0 - t) * EffectsOn(line.p) + t * EffectsOn(line.q);
      const Eigen::Vector3d measured = (1.0 - t) * line.p.uvd + t * line.q.uvd - effects * rest_now;
      const Eigen::Vector3d variances = (1.0 - t) * (1.0 - t) * variances_of(line.p) + t * t * variances_of(line.q);
      const Eigen::Matrix3d covariance = predicted.covariance + Eigen::Matrix3d(variances.asDiagonal());
      sum.Add<2>(across * (predicted.uvd - measured), across * (predicted.by_parameters + effects),
                 across * predicted.by_motion, across * covariance * across.transpose());
    }
  }
}

TimingCheck::Information TimingCheck::Prior() const {
  Parameters sigmas;
  sigmas << kLateSigma_frames * dt_s_, kReadoutSigma_frames * dt_s_, kReadoutSigma_frames * dt_s_,
      DisparityErrorSigmas(kOffsetSigma_px);
  return Information(sigmas.cwiseAbs2().cwiseInverse().asDiagonal());
}

/// Estimates the motion together with the parameters, whose prior is the evidence so far, and adds what remains of the
/// equations after the motion is eliminated.
void TimingCheck::Learn(const View& now) {
  const Information prior = Prior() + halves_[0].information + halves_[1].information;
  const Parameters mean = prior.ldlt().solve(halves_[0].vector + halves_[1].vector);
  Parameters parameters = mean;
  SE3 T_now_before = now.T_odom_c.Inverse() * begin_.T_odom_c;
  Sum sum;
  for (int i = 0; i < kIterations; ++i) {
    sum = Sum();
    sum.max_deviation = i < kIterations - kRejectingIterations ? 1e3 : kMaxDeviation;
    Add(now, T_now_before, parameters, sum);
    if (sum.count < kMinEquations) return;
    if (i == kIterations - 1) break;
    Eigen::Matrix<double, 12, 12> normal = sum.normal.leftCols<12>();
    Eigen::Matrix<double, 12, 1> vector = sum.normal.col(12);
    normal.topLeftCorner<6, 6>() += prior;
    vector.head<6>() += prior * (mean - parameters);
    const Eigen::Matrix<double, 12, 1> step = normal.ldlt().solve(vector);
    if (!step.allFinite()) return;
    parameters += step.head<6>();
    T_now_before = T_now_before * SE3::Exp(step.tail<6>());
  }
  const Eigen::LDLT<Matrix6d> motion(Matrix6d(sum.normal.block<6, 6>(6, 6)));
  if (motion.info() != Eigen::Success || !motion.isPositive() || !(motion.rcond() > 1e-12)) return;
  const Matrix6d cross = sum.normal.block<6, 6>(0, 6);
  const Information information =
      sum.normal.topLeftCorner<6, 6>() - cross * motion.solve(Matrix6d(cross.transpose()));
  const Parameters vector =
      sum.normal.col(12).head<6>() - cross * motion.solve(Vector6d(sum.normal.col(12).tail<6>()));
  for (Evidence& half : halves_) {
    half.information *= kMemory;
    half.vector *= kMemory;
    half.squares *= kMemory;
    half.count *= kMemory;
  }
  Evidence& half = halves_[static_cast<size_t>(n_pairs_++ % 2)];
  half.information += information;
  half.vector += vector + information * parameters;
  half.squares += sum.squares;
  half.count += sum.count - 6.0;
}

std::optional<TimingCheck::Estimate> TimingCheck::EstimateOf(int parameter) const {
  if (n_pairs_ < kMinPairs) return std::nullopt;
  const double squares = halves_[0].squares + halves_[1].squares;
  const double noise = std::max(std::sqrt(squares / (halves_[0].count + halves_[1].count)), kMinNoise);
  const auto solve = [&](const Information& information, const Parameters& vector) {
    const Information covariance = (Prior() + information).inverse();
    return Estimate{(covariance * vector)(parameter), noise * std::sqrt(covariance(parameter, parameter)), true};
  };
  const Estimate odd = solve(halves_[0].information, halves_[0].vector);
  const Estimate even = solve(halves_[1].information, halves_[1].vector);
  Estimate both = solve(halves_[0].information + halves_[1].information, halves_[0].vector + halves_[1].vector);
  both.halves_agree = std::abs(odd.value - even.value) < kDifferSigmas * Hypot(odd.sigma, even.sigma);
  return both;
}

}  // namespace plslam::vo
