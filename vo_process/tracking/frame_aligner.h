// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/tracking/local_landmarks.h"
#include "vo_process/tracking/motion_model.h"

namespace plslam::vo {

/// Pose of a frame among landmarks.
struct Alignment {
  SE3 T_odom_c;
  /// Of the right perturbation, given the landmarks.
  Matrix6d covariance = Matrix6d::Zero();
  /// Inliers.
  FrameMatches matches;
  /// Few inliers: the prior took part.
  bool weak = false;
  /// Typical residuals of each feature type in their own sigmas, as in `MotionEstimate`.
  double point_deviation = 0.0;
  double line_deviation = 0.0;
};

/// Finds a frame among landmarks: by projection from the expected pose, in a wider window, and at last by descriptors
/// and RANSAC; then once more by projection from the pose found (PL-SLAM §IV.C with a motion model, windowed matching
/// and verification). Values in, values out.
class FrameAligner {
 public:
  FrameAligner(const StereoCamera& camera, const VoOptions& options) : camera_(camera), options_(options) {}

  /// `T_odom_prev` is the pose of the frame before, `prediction` what is expected since, `expected_weight` the
  /// inliers (points + 2 x lines) that frame had; where nothing is expected, a number that no search reaches, so that
  /// all are compared. nullopt: lost.
  std::optional<Alignment> Align(const LocalLandmarks& landmarks, const TrackedFrame& frame, const SE3& T_odom_prev,
                                 const MotionPrediction& prediction, int expected_weight) const;

  /// Landmarks near where they should be seen from `T_odom_c`.
  FrameMatches MatchByProjection(const LocalLandmarks& landmarks, const TrackedFrame& frame, const SE3& T_odom_c,
                                 const Search& search) const;

  /// The pose that matches say, from `T_odom_initial` on; the result keeps those that agree. nullopt: not determined,
  /// or too few.
  std::optional<Alignment> Estimate(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                    const FrameMatches& matches, const SE3& T_odom_initial,
                                    const std::optional<MotionPrior>& prior) const {
    return Estimate(landmarks, frame, matches, T_odom_initial, prior, options_.motion);
  }

  /// Searches once more, for all landmarks, around a pose that was found; that one again where nothing better comes
  /// of it.
  Alignment Refine(const LocalLandmarks& landmarks, const TrackedFrame& frame, const Alignment& coarse,
                   const MotionPrior& prior) const;

 private:
  std::optional<Alignment> FindStrongest(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                         const SE3& T_odom_predicted, const MotionPrediction& prediction,
                                         int expected_weight) const;
  std::optional<Alignment> FindWeak(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                    const SE3& T_odom_predicted, const MotionPrior& prior) const;
  bool IsBetter(const Alignment& found, const Alignment& best, const SE3& T_odom_predicted,
                const MotionPrediction& prediction) const;
  std::optional<Alignment> Estimate(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                    const FrameMatches& matches, const SE3& T_odom_initial,
                                    const std::optional<MotionPrior>& prior, const MotionOptions& motion) const;
  std::optional<Alignment> FindByDescriptor(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                            const MotionOptions& motion) const;
  bool IsStrong(const std::optional<Alignment>& alignment, int matched) const;

  StereoCamera camera_;
  VoOptions options_;
};

}  // namespace plslam::vo
