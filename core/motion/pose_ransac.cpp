// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/pose_ransac.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/geometry/symmetric.h"
#include "core/geometry/triangulation.h"
#include "core/motion/alignment.h"
#include "core/motion/normal_equations.h"

namespace plslam {
namespace {

constexpr int kMaxHypotheses = 500;
constexpr int kMinHypotheses = 20;
constexpr double kConfidence = 0.999;
constexpr double kMinSineOfLines = 0.15;
constexpr int kMaxPolishing = 3;
constexpr double kDamping = 1e-6;

// SplitMix64: the distributions of the standard library differ between its implementations.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  /// Returns a number from 0 to n - 1.
  int Below(int n) {
    state_ += 0x9E3779B97F4A7C15ULL;
    uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    z ^= z >> 31U;
    return static_cast<int>((z >> 32U) * static_cast<uint64_t>(n) >> 32U);
  }

 private:
  uint64_t state_;
};

/// Elements of minimal sets: features with a 3D position in both frames; `index` is that in the caller's list.
struct PointPair {
  Eigen::Vector3d ref;
  Eigen::Vector3d cur;
  int index;
};
struct LinePair {
  Segment3 ref;
  Segment3 cur;
  int index;
};

class Ransac {
 public:
  Ransac(const std::vector<PointCorrespondence>& points, const std::vector<LineCorrespondence>& lines,
         const StereoCamera& camera, int min_inliers, double inlier_px, uint64_t seed,
         const std::optional<Neighbourhood>& neighbourhood);

  std::optional<SE3> Estimate();

 private:
  void FindNeighbours(const Neighbourhood& neighbourhood);
  /// Draws a point pair: any, or one near the `first` of a set.
  int Draw(int first);
  std::optional<SE3> Hypothesis();
  std::optional<SE3> FromPoints();
  std::optional<SE3> FromLines();
  SE3 Polished(const SE3& T_cur_ref, const std::vector<PointCorrespondence>& points,
               const std::vector<LineCorrespondence>& lines) const;
  ActiveSet Inliers(const SE3& T_cur_ref) const;
  int NeededHypotheses(int n_inliers) const;
  static int Score(const ActiveSet& set) { return set.CountPoints() + 2 * set.CountLines(); }

  const std::vector<PointCorrespondence>& points_;
  const std::vector<LineCorrespondence>& lines_;
  const StereoCamera& camera_;
  int min_inliers_;
  MotionOptions options_;
  RobustExpectations expectations_;
  PreparedCorrespondences correspondences_;
  std::vector<PointPair> point_pairs_;
  std::vector<LinePair> line_pairs_;
  /// Neighbours of each point pair; empty if sets may be spread over the image.
  std::vector<std::vector<int>> neighbours_;
  int max_hypotheses_ = kMaxHypotheses;
  Random random_;
};

// Gates in pixels, not in sigmas: matches that only an uncertain landmark explains are no evidence for a pose.
MotionOptions PixelGates(double inlier_px) {
  MotionOptions options;
  options.landmark_covariance = false;
  options.min_scale_px = inlier_px / std::sqrt(ChiSquareQuantile(2, options.gate_sigmas));
  return options;
}

Ransac::Ransac(const std::vector<PointCorrespondence>& points, const std::vector<LineCorrespondence>& lines,
               const StereoCamera& camera, int min_inliers, double inlier_px, uint64_t seed,
               const std::optional<Neighbourhood>& neighbourhood)
    : points_(points),
      lines_(lines),
      camera_(camera),
      min_inliers_(min_inliers),
      options_(PixelGates(inlier_px)),
      expectations_(ExpectRobust(options_.huber_delta, options_.gate_sigmas)),
      correspondences_(points, lines, options_),
      random_(seed) {
  for (const int i : correspondences_.point_index) {
    const PointCorrespondence& o = points[i];
    if (o.uvd.z() > 0.0) point_pairs_.push_back({o.p_ref, camera.Backproject(o.uvd), i});
  }
  for (const int i : correspondences_.line_index) {
    const LineCorrespondence& o = lines[i];
    if (o.disparity_p_px <= 0.0 || o.disparity_q_px <= 0.0) continue;
    line_pairs_.push_back(
        {o.segment_ref, BackprojectSegment(camera, o.observed, o.disparity_p_px, o.disparity_q_px), i});
  }
  if (neighbourhood) FindNeighbours(*neighbourhood);
}

void Ransac::FindNeighbours(const Neighbourhood& neighbourhood) {
  max_hypotheses_ = neighbourhood.max_hypotheses;
  neighbours_.resize(point_pairs_.size());
  for (size_t i = 0; i < point_pairs_.size(); ++i) {
    const Eigen::Vector3d& here = points_[point_pairs_[i].index].uvd;
    for (size_t j = 0; j < point_pairs_.size(); ++j) {
      const Eigen::Vector3d& there = points_[point_pairs_[j].index].uvd;
      const bool near = (here - there).head<2>().squaredNorm() <= neighbourhood.radius_px * neighbourhood.radius_px &&
                        std::abs(here.z() - there.z()) <= neighbourhood.relative_disparity * here.z();
      if (i != j && near) neighbours_[i].push_back(static_cast<int>(j));
    }
  }
}

int Ransac::Draw(int first) {
  if (first < 0 || neighbours_.empty()) return random_.Below(static_cast<int>(point_pairs_.size()));
  const std::vector<int>& near = neighbours_[first];
  return near.empty() ? first : near[random_.Below(static_cast<int>(near.size()))];
}

std::optional<SE3> Ransac::FromPoints() {
  std::array<Eigen::Vector3d, 3> ref;
  std::array<Eigen::Vector3d, 3> cur;
  std::array<int, 3> chosen{};
  for (int i = 0; i < 3; ++i) {
    chosen[i] = Draw(i == 0 ? -1 : chosen[0]);
    for (int j = 0; j < i; ++j) {
      if (chosen[j] == chosen[i]) return std::nullopt;
    }
    ref[i] = point_pairs_[chosen[i]].ref;
    cur[i] = point_pairs_[chosen[i]].cur;
  }
  const auto aligned = AlignPoints(ref, cur);
  if (!aligned) return std::nullopt;
  std::vector<PointCorrespondence> minimal;
  minimal.reserve(chosen.size());
  for (const int i : chosen) minimal.push_back(points_[point_pairs_[i].index]);
  return Polished(*aligned, minimal, {});
}

std::optional<SE3> Ransac::FromLines() {
  const int n = static_cast<int>(line_pairs_.size());
  const int first = random_.Below(n);
  const int second = random_.Below(n);
  if (first == second) return std::nullopt;
  const LinePair& a = line_pairs_[first];
  const LinePair& b = line_pairs_[second];
  const auto aligned = AlignLines(a.ref, b.ref, a.cur, b.cur, kMinSineOfLines);
  if (!aligned) return std::nullopt;
  return Polished(*aligned, {}, {lines_[a.index], lines_[b.index]});
}

/// Refines a pose by minimising the reprojection error of its minimal set. At small disparities 3D positions, and poses
/// aligned with them, are metres off along the rays, while the pixels are nearly correct.
SE3 Ransac::Polished(const SE3& T_cur_ref, const std::vector<PointCorrespondence>& points,
                     const std::vector<LineCorrespondence>& lines) const {
  const PreparedCorrespondences minimal(points, lines, options_);
  const ActiveSet all{std::vector<char>(minimal.points.size(), 1), std::vector<char>(minimal.lines.size(), 1)};
  SE3 best = T_cur_ref;
  NormalEquations sum = BuildNormalEquations(minimal, all, best, camera_, expectations_, options_);
  for (int i = 0; i < kMaxPolishing; ++i) {
    Matrix6d damped = sum.H();
    damped.diagonal() *= 1.0 + kDamping;
    const Vector6d x = SolveSymmetric<6>(damped, sum.g);
    if (!x.allFinite()) break;
    const SE3 trial = SE3::Exp(x) * best;
    const NormalEquations at_trial = BuildNormalEquations(minimal, all, trial, camera_, expectations_, options_);
    if (at_trial.cost >= sum.cost) break;
    best = trial;
    sum = at_trial;
  }
  return best;
}

std::optional<SE3> Ransac::Hypothesis() {
  const bool can_points = point_pairs_.size() >= 3;
  const bool can_lines = line_pairs_.size() >= 2;
  if (!can_points && !can_lines) return std::nullopt;
  const int total = static_cast<int>(point_pairs_.size() + 2 * line_pairs_.size());
  const bool points = can_points && (!can_lines || random_.Below(total) < static_cast<int>(point_pairs_.size()));
  return points ? FromPoints() : FromLines();
}

ActiveSet Ransac::Inliers(const SE3& T_cur_ref) const {
  const auto keep = [](const std::vector<Deviation>& deviations) {
    std::vector<char> flags;
    flags.reserve(deviations.size());
    for (const Deviation& d : deviations) flags.push_back(d.squared <= d.gate ? 1 : 0);
    return flags;
  };
  return {keep(PointDeviations(correspondences_, T_cur_ref, camera_, options_)),
          keep(LineDeviations(correspondences_, T_cur_ref, camera_, options_))};
}

int Ransac::NeededHypotheses(int n_inliers) const {
  const double all = static_cast<double>(correspondences_.points.size() + 2 * correspondences_.lines.size());
  const double share = std::clamp(n_inliers / all, 1e-3, 0.999);
  const double needed = std::log(1.0 - kConfidence) / std::log(1.0 - share * share * share);
  // Clamped before the cast: the number for few inliers among many exceeds int.
  return static_cast<int>(std::clamp<double>(std::ceil(needed), kMinHypotheses, max_hypotheses_));
}

std::optional<SE3> Ransac::Estimate() {
  std::optional<SE3> best;
  int best_score = 0;
  int needed = max_hypotheses_;
  for (int i = 0; i < needed; ++i) {
    const std::optional<SE3> hypothesis = Hypothesis();
    if (!hypothesis || !hypothesis->IsFinite()) continue;
    const int score = Score(Inliers(*hypothesis));
    if (score <= best_score) continue;
    best = hypothesis;
    best_score = score;
    needed = NeededHypotheses(score);
  }
  if (!best) return std::nullopt;
  // A pose from a minimal set is noisy: refining it with all inliers often finds more.
  MotionOptions refinement;
  refinement.min_inliers = std::max(3, std::min(min_inliers_, best_score));
  const auto refined = EstimateMotion(points_, lines_, camera_, *best, std::nullopt, refinement);
  if (refined && Score(Inliers(refined->T_cur_ref)) >= best_score) {
    best = refined->T_cur_ref;
    best_score = Score(Inliers(*best));
  }
  return best_score >= min_inliers_ ? best : std::nullopt;
}

}  // namespace

std::optional<SE3> EstimatePoseRansac(const std::vector<PointCorrespondence>& points,
                                      const std::vector<LineCorrespondence>& lines, const StereoCamera& camera,
                                      int min_inliers, double inlier_px, uint64_t seed,
                                      const std::optional<Neighbourhood>& neighbourhood) {
  if (!(inlier_px > 0.0) || !std::isfinite(inlier_px)) return std::nullopt;
  return Ransac(points, lines, camera, min_inliers, inlier_px, seed, neighbourhood).Estimate();
}

}  // namespace plslam
