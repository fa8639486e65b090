// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/stereo/rolling_shutter.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/motion/motion_model.h"

namespace plslam::vo {

/// Pose of a frame relative to landmarks.
struct Alignment {
  SE3 T_odom_c;
  /// Covariance of the right perturbation, given the landmarks.
  Matrix6d covariance = Matrix6d::Zero();
  /// Inliers.
  FrameMatches matches;
  /// Whether the prior took part, because there were few inliers.
  bool weak = false;
  /// Typical residuals of each feature type in units of their sigmas, as in `MotionEstimate`.
  double point_deviation = 0.0;
  double line_deviation = 0.0;
};

/// Localises a frame among landmarks: by projection from the predicted pose, then in a wider window, then by
/// descriptors and RANSAC; and again by projection from the estimated pose (PL-SLAM §IV.C with a motion model,
/// windowed matching and verification). Stateless.
class FrameAligner {
 public:
  FrameAligner(const StereoCamera& camera, const VoOptions& options) : camera_(camera), options_(options) {}

  /// `T_odom_prev` is the pose of the previous frame, `prediction` the motion since, `expected_weight` the inlier score
  /// (points + 2 x lines) of that frame; without a prediction, a number that no search reaches, so that all searches
  /// are compared. Returns nullopt if the frame is lost.
  std::optional<Alignment> Align(const LocalLandmarks& landmarks, const TrackedFrame& frame, const SE3& T_odom_prev,
                                 const MotionPrediction& prediction, int expected_weight) const;

  /// Matches landmarks near their projection from `T_odom_c`.
  FrameMatches MatchByProjection(const LocalLandmarks& landmarks, const TrackedFrame& frame, const SE3& T_odom_c,
                                 const Search& search) const;

  /// Estimates the pose from matches, starting at `T_odom_initial`; the result contains the inliers. Returns nullopt if
  /// it is not determined or there are too few.
  std::optional<Alignment> Estimate(const LocalLandmarks& landmarks, const TrackedFrame& frame,
                                    const FrameMatches& matches, const SE3& T_odom_initial,
                                    const std::optional<MotionPrior>& prior) const {
    return Estimate(landmarks, frame, matches, T_odom_initial, prior, options_.motion);
  }

  /// Estimates the pose of an alignment again with a prior. Returns `found` if that fails.
  Alignment WithPrior(const LocalLandmarks& landmarks, const TrackedFrame& frame, const Alignment& found,
                      const MotionPrior& prior) const;

  /// Sets the disparities by which matched features without depth are moved to those of their landmarks.
  void SetDisparities(const LocalLandmarks& landmarks, const Alignment& alignment, RollingFrame& rolling) const;

  /// Matches all landmarks again around an estimated pose; returns `coarse` if the result is not better.
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
