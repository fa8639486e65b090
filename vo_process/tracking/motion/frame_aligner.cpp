// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/frame_aligner.h"

#include <limits>
#include <utility>

#include "core/features/matching/segment_projection.h"
#include "core/motion/pose_ransac.h"

namespace plslam::vo {
namespace {

// Landmarks unseen for longer are not matched before the pose is known.
constexpr int kRecentFrames = 2;
constexpr double kRansacInlier_px = 4.0;
constexpr uint64_t kRansacSeed = 1;
// Factor of chi-square above which an unexpected motion counts as farther away than an expected one.
constexpr double kFartherChi2 = 4.0;

// The first estimate only needs to bring landmarks into the second search window.
MotionOptions Coarse(MotionOptions options) {
  options.max_refinements = 1;
  return options;
}

// Without a prediction, two motions may fill the view alike. A gate that grows with the residuals would admit both into
// an estimate between them, so it keeps its minimum: only a consensus then has many inliers.
MotionOptions Consensus(MotionOptions options) {
  options.max_scale = 1.0;
  return options;
}

int Weight(const MotionEstimate& estimate) { return estimate.n_point_inliers + 2 * estimate.n_line_inliers; }

std::vector<LandmarkMatch> Inliers(const std::vector<LandmarkMatch>& matches, const std::vector<bool>& inlier) {
  std::vector<LandmarkMatch> kept;
  for (size_t i = 0; i < matches.size(); ++i) {
    if (inlier[i]) kept.push_back(matches[i]);
  }
  return kept;
}

}  // namespace

std::optional<Alignment> FrameAligner::Align(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                             const SE3& T_odom_prev, const MotionPrediction& prediction,
                                             int expected_weight) const {
  const SE3 T_odom_predicted = T_odom_prev * prediction.T_prev_c;
  const MotionPrior prior{T_odom_predicted.Inverse(), prediction.covariance};
  auto coarse = FindStrongest(landmarks, frame, T_odom_predicted, prediction, expected_weight);
  if (!coarse) coarse = FindWeak(landmarks, frame, T_odom_predicted, prior);
  if (!coarse) return std::nullopt;
  return Refine(landmarks, frame, *coarse, prior);
}

std::optional<Alignment> FrameAligner::FindStrongest(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                                     const SE3& T_odom_predicted, const MotionPrediction& prediction,
                                                     int expected_weight) const {
  // A few wrong matches may agree by chance if the correct ones are outside the window: an alignment much weaker than
  // the last frame's is accepted only if no better one is found.
  const double convincing = options_.tracking.accepted_ratio * expected_weight;
  const bool expects_nothing = expected_weight == std::numeric_limits<int>::max();
  const MotionOptions motion = expects_nothing ? Consensus(Coarse(options_.motion)) : Coarse(options_.motion);
  std::optional<Alignment> best;
  const auto consider = [&](std::optional<Alignment> found) {
    if (found && (!best || IsBetter(*found, *best, T_odom_predicted, prediction))) best = std::move(found);
    return best && best->matches.Weight() >= convincing;
  };
  for (const double radius_px : {options_.tracking.search_radius_px, options_.tracking.wide_radius_px}) {
    const FrameMatches matches = MatchByProjection(landmarks, frame, T_odom_predicted, {radius_px, kRecentFrames});
    auto found = Estimate(landmarks, frame, matches, T_odom_predicted, std::nullopt, motion);
    if (IsStrong(found, matches.Weight()) && consider(std::move(found))) return best;
  }
  consider(FindByDescriptor(landmarks, frame, motion));
  return best;
}

// With few features, takes the window in which most of them agree with each other and with the prior.
std::optional<Alignment> FrameAligner::FindWeak(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                                const SE3& T_odom_predicted, const MotionPrior& prior) const {
  std::optional<Alignment> best;
  for (const double radius_px : {options_.tracking.search_radius_px, options_.tracking.wide_radius_px}) {
    const FrameMatches matches = MatchByProjection(landmarks, frame, T_odom_predicted, {radius_px, kRecentFrames});
    auto found = Estimate(landmarks, frame, matches, T_odom_predicted, prior, Coarse(options_.motion));
    if (found && (!best || found->matches.Weight() > best->matches.Weight())) best = std::move(found);
  }
  if (best) best->weak = true;
  return best;
}

// Repeated structure agrees equally well one period away: an alignment far from the prediction needs more inliers.
bool FrameAligner::IsBetter(const Alignment& found, const Alignment& best, const SE3& T_odom_predicted,
                            const MotionPrediction& prediction) const {
  const auto chi2 = [&](const Alignment& alignment) {
    return SquaredDeviation(prediction, T_odom_predicted, alignment.T_odom_c);
  };
  const bool is_elsewhere = prediction.is_reliable && chi2(found) > kExpectedChi2 + kFartherChi2 * chi2(best);
  const double needed = is_elsewhere ? options_.tracking.elsewhere_ratio : 1.0;
  return found.matches.Weight() > needed * best.matches.Weight();
}

FrameMatches FrameAligner::MatchByProjection(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                             const SE3& T_odom_c, const Search& search) const {
  const SE3 T_c_odom = T_odom_c.Inverse();
  return {landmarks.points.MatchByProjection(T_c_odom, frame, search, options_.point_matching),
          landmarks.lines.MatchByProjection(T_c_odom, frame, search, options_.line_matching)};
}

std::optional<Alignment> FrameAligner::Estimate(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                                const FrameMatches& matches, const SE3& T_odom_initial,
                                                const std::optional<MotionPrior>& prior,
                                                const MotionOptions& motion) const {
  if (matches.Weight() < options_.tracking.min_inliers) return std::nullopt;
  const auto estimate = EstimateMotion(landmarks.points.Observations(matches.points, frame),
                                       landmarks.lines.Observations(matches.lines, frame), camera_,
                                       T_odom_initial.Inverse(), prior, motion);
  if (!estimate || Weight(*estimate) < options_.tracking.min_inliers) return std::nullopt;
  Alignment alignment;
  alignment.T_odom_c = estimate->T_cur_ref.Inverse();
  alignment.covariance = estimate->covariance;
  alignment.point_deviation = estimate->point_deviation;
  alignment.line_deviation = estimate->line_deviation;
  alignment.matches = {Inliers(matches.points, estimate->point_inliers),
                       Inliers(matches.lines, estimate->line_inliers)};
  return alignment;
}

std::optional<Alignment> FrameAligner::FindByDescriptor(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                                        const MotionOptions& motion) const {
  const FrameMatches matches{landmarks.points.MatchByDescriptor(frame, kRecentFrames, options_.point_matching),
                             landmarks.lines.MatchByDescriptor(frame, kRecentFrames, options_.line_matching)};
  const auto T_c_odom = EstimatePoseRansac(landmarks.points.Observations(matches.points, frame),
                                           landmarks.lines.Observations(matches.lines, frame), camera_,
                                           options_.tracking.weak_inliers, kRansacInlier_px, kRansacSeed);
  if (!T_c_odom) return std::nullopt;
  // Match again around the estimated pose, so that the share of inliers shows whether it is correct.
  const SE3 T_odom_c = T_c_odom->Inverse();
  const Search near{options_.tracking.search_radius_px, kRecentFrames};
  const FrameMatches guided = MatchByProjection(landmarks, frame, T_odom_c, near);
  auto coarse = Estimate(landmarks, frame, guided, T_odom_c, std::nullopt, motion);
  if (!IsStrong(coarse, guided.Weight())) return std::nullopt;
  return coarse;
}

Alignment FrameAligner::Refine(const LocalLandmarks& landmarks, const TrackedFrame& frame, const Alignment& coarse,
                               const MotionPrior& prior) const {
  const Search all{options_.tracking.refine_radius_px, options_.landmarks.max_unseen_frames};
  const FrameMatches matches = MatchByProjection(landmarks, frame, coarse.T_odom_c, all);
  std::optional<MotionPrior> used_prior;
  if (coarse.weak) used_prior = prior;
  auto fine = Estimate(landmarks, frame, matches, coarse.T_odom_c, used_prior, options_.motion);
  if (!fine || fine->matches.Weight() < coarse.matches.Weight()) return coarse;
  fine->weak = coarse.weak;
  return *fine;
}

Alignment FrameAligner::WithPrior(const LocalLandmarks& landmarks, const TrackedFrame& frame, const Alignment& found,
                                  const MotionPrior& prior) const {
  // The inliers are known, and the start is near: one refinement is enough.
  const auto both = Estimate(landmarks, frame, found.matches, found.T_odom_c, prior, Coarse(options_.motion));
  if (!both) return found;
  Alignment with_prior = found;
  with_prior.T_odom_c = both->T_odom_c;
  with_prior.covariance = both->covariance;
  return with_prior;
}

void FrameAligner::SetDisparities(const LocalLandmarks& landmarks, const Alignment& alignment,
                                  RollingFrame& rolling) const {
  const SE3 T_c_odom = alignment.T_odom_c.Inverse();
  for (const LandmarkMatch& match : alignment.matches.points) {
    if (rolling.measured().points[match.feature].HasDepth()) continue;
    const Eigen::Vector3d p_c = T_c_odom * landmarks.points.landmarks()[match.landmark].p_odom;
    if (p_c.z() > camera_.MinDepth()) rolling.SetPointDisparity(match.feature, camera_.FocalBaseline() / p_c.z());
  }
  for (const LandmarkMatch& match : alignment.matches.lines) {
    const StereoLine& line = rolling.measured().lines[match.feature];
    if (line.HasDepth()) continue;
    const Segment3& segment = landmarks.lines.landmarks()[match.landmark].segment_odom;
    const Segment3 segment_c{T_c_odom * segment.p, T_c_odom * segment.q};
    const auto disparity_px = [&](const Eigen::Vector2d& px) {
      const auto along = AlongLine(segment_c, px, camera_);
      const double z = along ? (segment_c.p + *along * (segment_c.q - segment_c.p)).z() : 0.0;
      return z > camera_.MinDepth() ? camera_.FocalBaseline() / z : -1.0;
    };
    const double p_px = disparity_px(line.left.segment.p);
    const double q_px = disparity_px(line.left.segment.q);
    if (p_px > 0.0 && q_px > 0.0) rolling.SetLineDisparities(match.feature, p_px, q_px);
  }
}

bool FrameAligner::IsStrong(const std::optional<Alignment>& alignment, int matched) const {
  if (!alignment) return false;
  const int weight = alignment->matches.Weight();
  return weight >= options_.tracking.weak_inliers && weight >= options_.tracking.min_inlier_ratio * matched;
}

}  // namespace plslam::vo
