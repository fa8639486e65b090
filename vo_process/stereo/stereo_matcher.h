// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <cstddef>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/feature_extractor.h"
#include "core/features/features.h"
#include "core/features/options.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/stereo/dirt_cells.h"
#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/point_stereo.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// Matches both feature types of one pair (PL-SLAM §IV.A-B): row buckets, mutual best, ratio test, or a search along
/// the row, then sub-pixel disparity by comparing the images, with its standard deviation. All left features are kept;
/// those without a match, and segments nearly parallel to the baseline, have no depth.
///
/// Split into steps, so that two threads can share the work; results do not depend on the assignment.
class PairMatcher {
 public:
  /// `rows` is the vertical disparity of the pair. All arguments must outlive the matcher.
  PairMatcher(const HalvedPair& pair, const RowField& rows, const StereoOptions& options);

  /// Call once, before `MatchPoints`. Without right points all left points are searched along their rows.
  void SetPoints(std::vector<PointFeature> left, std::vector<PointFeature> right);

  /// May run on any number of threads, in parallel with `MatchLines`; returns when no point is left.
  void MatchPoints();

  /// `dirt` as in `MatchLinesStereo`.
  void MatchLines(std::vector<LineFeature> left, std::vector<LineFeature> right, const PairDirt& dirt = {});

  /// Call after all of the above have returned.
  StereoFeatures Finish();

 private:
  const HalvedPair& pair_;
  const RowField& rows_;
  const StereoOptions& options_;
  std::vector<PointFeature> right_points_;
  std::vector<PointCandidate> candidates_;
  std::atomic<size_t> begun_points_ = 0;
  StereoFeatures features_;
};

/// Converts disparities as measured to those of a simultaneous pair without residual rotation.
void ToSimultaneous(const RowField& rows, StereoFeatures& features);

/// Runs all steps for extracted features. `run_both` shares the work between two threads.
StereoFeatures MatchStereo(ImageFeatures left, ImageFeatures right, const cv::Mat& left_image,
                           const cv::Mat& right_image, const RowField& rows, const StereoOptions& options,
                           const RunBoth& run_both = RunInTurn);

/// Sets depths from a depth map aligned with the left image (16 bits, 0 = unknown), as virtual right measurements
/// d = b f / Z; for lines from depths sampled robustly along the segment.
StereoFeatures AttachDepth(ImageFeatures left, const cv::Mat& depth, double depth_units_per_m,
                           const StereoCamera& camera, const StereoOptions& options);

}  // namespace plslam::vo
