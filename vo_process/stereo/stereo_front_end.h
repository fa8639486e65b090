// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include <opencv2/core/mat.hpp>

#include "core/features/feature_extractor.h"
#include "core/geometry/rectifier.h"
#include "core/io/images/image_file.h"
#include "vo_process/options.h"
#include "vo_process/stereo/row_field.h"
#include "vo_process/stereo/side_worker.h"
#include "vo_process/stereo/stage_timer.h"

namespace plslam::vo {

/// From a recorded stereo pair to stereo features: rectification, points of the left image and lines of both, stereo
/// matching (PL-SLAM §IV.A-B), shared between two threads. For RGB-D rigs the depth map takes the right image's
/// place.
class StereoFrontEnd {
 public:
  /// Throws std::runtime_error where the rig cannot be rectified.
  StereoFrontEnd(const RigCalibration& rig, const VoOptions& options);

  const StereoCamera& camera() const { return rectifier_.camera(); }

  /// What is left out of the pairs that follow, beside what the rig leaves out.
  void SetMask(const FrameMask& mask);

  /// Features in rectified left pixels; `rows` is what is known of rows that differ between the two rectified images,
  /// `max_points` how many corners are wanted, where not as many as the options say. Throws std::runtime_error where
  /// the images do not fit the rig.
  StereoFeatures Process(const StereoImages& images, StageTimer& timer, const RowField& rows = {},
                         std::optional<int> max_points = std::nullopt);

  /// Points of a pair whose rows may differ by several pixels, to learn them from: corners of both images are
  /// compared, tolerant of such rows, and disparities are less sure for it.
  StereoFeatures LookForRows(const StereoImages& images, const PairSkew& skew = {});

 private:
  bool LeavesOutLeft() const { return !rig_.left.mask.empty() || !mask_.left.empty(); }
  bool LeavesOutRight() const { return !rig_.right.mask.empty() || !mask_.right.empty(); }
  RunBoth OnBothThreads();
  StereoFeatures ProcessStereo(const StereoImages& images, StageTimer& timer, const RowField& rows,
                               std::optional<int> max_points);
  StereoFeatures ProcessRgbd(const StereoImages& images, StageTimer& timer, std::optional<int> max_points);

  RigCalibration rig_;
  VoOptions options_;
  Rectifier rectifier_;
  // Against the edge of the warped image, what the rig leaves out, and what is left out of this pair.
  FeatureMask left_mask_;
  FeatureMask right_mask_;
  FrameMask mask_;
  FeatureExtractor left_extractor_;
  FeatureExtractor right_extractor_;
  SideWorker worker_;
};

}  // namespace plslam::vo
