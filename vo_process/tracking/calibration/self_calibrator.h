// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/stereo/rolling_shutter.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/calibration/corner_budget.h"
#include "vo_process/tracking/calibration/dirty_lenses.h"
#include "vo_process/tracking/calibration/disparity_calibration.h"
#include "vo_process/tracking/calibration/noise_scale.h"
#include "vo_process/tracking/calibration/row_calibration.h"
#include "vo_process/tracking/calibration/self_calibration.h"
#include "vo_process/tracking/calibration/sync_check.h"
#include "vo_process/tracking/calibration/timing_check.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"
#include "vo_process/tracking/motion/stamp_velocity.h"

namespace plslam::vo {

/// Errors of a pair of cameras that are learned while driving, and corrected: vertical disparities, the offset of the
/// disparities, the delay of the right image, the readout of the rows, and the noise of points.
///
/// For each frame: `PredictSkew` and `SeePair`, `Prepare`; `MoveToStamp` when a velocity is known; after it was
/// tracked, the `Learn` functions in their order, otherwise `Interrupt`; last, `ObserveCorners`.
class SelfCalibrator {
 public:
  /// A `shutter` that is not global is stated by the calibration, and is not changed.
  SelfCalibrator(const StereoCamera& camera, const VoOptions& options, const RollingShutter& shutter);

  /// Starts with the estimates of another tracker with the same cameras; before the first frame.
  void Begin(const SelfCalibration& learned);
  SelfCalibration learned() const { return {rows_.learned(), disparities_.learned()}; }

  /// Vertical disparity of the next pair, with its skew.
  RowField rows() const { return rows_.field().With(skew_); }
  const DisparityCalibration& disparities() const { return disparities_; }
  const SyncCheck& sync() const { return sync_; }
  const DirtyLenses& lenses() const { return lenses_; }

  /// Readout time of the rows that was found although the calibration states none; 0 until it is significant.
  double found_readout_s() const { return states_readout_ ? 0.0 : shutter_.readout_s(); }
  /// Readout time that the images show, if it contradicts the stated one significantly; 0 otherwise.
  double contradicting_readout_s() const;
  /// Distance that the camera moves while the rows of the last image are read.
  double PathOfReadout_m() const { return shutter_.readout_s() * velocity_.last().head<3>().norm(); }

  /// Sets the skew of the next pair, given the predicted motion in the `dt_s` before it.
  void PredictSkew(const SE3& T_prev_c, double dt_s);

  /// Whether the calibration needs the features of the next pair to be detected: vertical disparities may be large, or an
  /// offset of the disparities matters that is not well known yet. Followed features show it less well.
  bool NeedsDetection() const { return rows_.needs_look() || disparities_.NeedsMeasurements(); }
  /// Learns from features that were followed into a pair, and removes those on dirt. Returns false if they have to be
  /// detected, because a vertical disparity is first applied.
  bool Accepts(StereoFeatures& followed);

  /// Detects the stereo features of the pair that `front_end` has taken, using and learning its vertical disparity. The
  /// first pair is processed twice, because it creates landmarks: first for vertical disparities that may be large. So
  /// are further pairs until enough was seen, and a pair that changes whether a vertical disparity is applied, or first
  /// shows dirt.
  StereoFeatures SeePair(StereoFrontEnd& front_end, StageTimer& timer);

  /// Applies what was learned about the measurements: their noise, and the offset of the disparities.
  TrackedFrame Prepare(StereoFeatures features) const;

  /// Moves the features to where a camera of this velocity observes them at the time of the stamp, if their rows are
  /// not simultaneous.
  void MoveToStamp(const Vector6d& velocity, TrackedFrame& frame) const;
  /// Velocity at the stamp, given the mean since the previous frame.
  Vector6d VelocityAfter(const Vector6d& mean) const { return velocity_.After(mean); }

  /// Updates the noise of points from the residuals of a tracked frame.
  void LearnNoise(const Alignment& alignment) { noise_scale_.Observe(alignment); }

  // The next three learn from a tracked frame, and correct it as soon as an error is first applied, or no longer. Then
  // they return true: all landmarks and disparities so far are displaced.

  /// Learns the times of rows and images from motions over several frames.
  bool LearnTiming(const SE3& T_odom_c, const SE3& T_prev_c, double dt_s, TrackedFrame& frame);
  /// Learns the offset of the disparities.
  bool LearnDisparities(const SE3& T_odom_c, TrackedFrame& frame);
  /// Learns the delay of the right image from rows.
  bool LearnDelay(const SE3& T_prev_c, double dt_s, TrackedFrame& frame);

  /// Instead of `LearnTiming` after a frame whose motion is unknown.
  void InterruptTiming();
  /// The frame was not tracked.
  void Interrupt();

  /// Updates the number of corners to detect after a frame, tracked or lost.
  void ObserveCorners(const TrackedFrame& frame) { corner_budget_.Observe(frame); }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.noise_scale_, self.disparities_, self.rows_, self.corner_budget_, self.sync_, self.velocity_, self.timing_,
      self.shutter_, self.lenses_);
  }

 private:
  bool LearnRows(const StereoFeatures& features);
  bool UseFoundReadout(const Vector6d& velocity, TrackedFrame& frame);

  StereoCamera camera_;
  VoOptions options_;
  NoiseScale noise_scale_;
  DisparityCalibration disparities_;
  RowCalibration rows_;
  CornerBudget corner_budget_;
  DirtyLenses lenses_;
  SyncCheck sync_;
  TimingCheck timing_;
  RollingShutter shutter_;
  bool states_readout_;  ///< whether the calibration states the readout
  StampVelocity velocity_;
  PairSkew skew_;  ///< of the next pair
};

}  // namespace plslam::vo
