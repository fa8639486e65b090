// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/features/feature_extractor.h"
#include "core/features/points/orb_detector.h"
#include "core/geometry/rectifier.h"
#include "core/io/images/image_file.h"
#include "vo_process/options.h"
#include "vo_process/stereo/dirt_cells.h"
#include "vo_process/stereo/feature_tracker.h"
#include "vo_process/stereo/rectified_pair.h"
#include "vo_process/stereo/rolling_shutter.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/stereo/side_worker.h"
#include "vo_process/stereo/stage_timer.h"

namespace plslam::vo {

/// Computes stereo features of a recorded pair: rectification, points of the left image and lines of both, stereo
/// matching (PL-SLAM §IV.A-B), on two threads. For RGB-D rigs the depth map replaces the right image.
class StereoFrontEnd {
 public:
  /// Throws std::runtime_error if the rig cannot be rectified.
  StereoFrontEnd(const RigCalibration& rig, const VoOptions& options);

  const StereoCamera& camera() const { return rectifier_.camera(); }
  /// The shutter that the rig states.
  RollingShutter shutter() const {
    RollingShutter shutter(rectifier_.rectification(), 1e-3 * rig_.left.readout_ms, options_.rolling_shutter.stamp);
    if (rig_.kind == RigCalibration::Kind::kRgbd) shutter.SetDepthMap();
    return shutter;
  }

  /// Masks regions of the following pairs, in addition to the rig's masks.
  void SetMask(const FrameMask& mask);

  /// Sets what is known of dirt on the lenses, for the following pairs.
  void SetDirt(PairDirt dirt) { dirt_ = std::move(dirt); }

  /// Rectifies the next pair, for the functions below. Throws std::runtime_error if the images do not fit the rig.
  void Take(const StereoImages& images, StageTimer& timer);
  /// The last pair.
  const RectifiedPair& pair() const { return pair_; }

  /// Detects features in the last pair, in rectified left pixels; `rows` is its known vertical disparity, `max_points` the
  /// number of corners if it differs from the options.
  StereoFeatures Detect(StageTimer& timer, const RowField& rows = {}, std::optional<int> max_points = std::nullopt);

  /// Finds the features of an earlier pair in the last one; for the poses see `FeatureTracker::Track`.
  StereoFeatures Follow(StageTimer& timer, const RowField& rows, const SE3& T_odom_previous, const SE3& T_odom_now,
                        FeatureTracker& tracker);

  /// `Take` and `Detect`.
  StereoFeatures Process(const StereoImages& images, StageTimer& timer) {
    Take(images, timer);
    return Detect(timer);
  }

  /// Corners of the right image of the last pair in rectified pixels, at half size: coarse, but cheap. None of depth
  /// maps, nor if the options exclude points.
  const std::vector<Eigen::Vector2d>& right_corners() const { return right_corners_; }

  /// Regions of the rectified images in which features are found.
  const FeatureMask& left_mask() const { return left_mask_; }
  const FeatureMask& right_mask() const { return right_mask_; }

  /// Returns points of the last pair for estimating a vertical disparity of several pixels: compares corners of both
  /// images with a wide row tolerance. Their disparities are less accurate for it.
  StereoFeatures LookForRows(const PairSkew& skew = {});

 private:
  bool LeavesOutLeft() const { return !rig_.left.mask.empty() || !mask_.left.empty(); }
  bool LeavesOutRight() const { return !rig_.right.mask.empty() || !mask_.right.empty(); }
  bool IsMasked(const StereoLine& line) const;
  RunBoth OnBothThreads();
  void FindRightCorners();
  StereoFeatures DetectStereo(StageTimer& timer, const RowField& rows, std::optional<int> max_points);
  StereoFeatures DetectRgbd(StageTimer& timer, std::optional<int> max_points);

  RigCalibration rig_;
  VoOptions options_;
  Rectifier rectifier_;
  // Masks: edge of the warped image, the rig's masks, and the mask of this pair.
  FeatureMask left_mask_;
  FeatureMask right_mask_;
  FrameMask mask_;
  PairDirt dirt_;
  FeatureExtractor left_extractor_;
  FeatureExtractor right_extractor_;
  CornerDetector right_detector_;
  std::vector<Eigen::Vector2d> right_corners_;
  SideWorker worker_;
  RectifiedPair pair_;
};

}  // namespace plslam::vo
