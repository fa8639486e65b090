#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/features/options.h"
#include "core/features/run_both.h"

namespace plslam {

/// `points` as stereo points without depth, with `sigma_px` set from their scales.
std::vector<StereoPoint> WithoutDepth(std::vector<PointFeature> points, const StereoOptions& options);

/// Finds the right point of each left one and sets its disparity and standard deviation (PL-SLAM §IV.A).
///
/// Candidates lie on the same row within `point_row_tolerance_px` times the scale of their octave, at most one octave
/// apart, with a disparity in range; the nearest descriptor must be near enough, clearly nearer than the second, and
/// mutually best. The disparity is then measured by aligning the patches of the two images (`PatchAligner`) and
/// dropped where they do not correlate. Points without a match keep a negative disparity.
void MatchPointsStereo(std::vector<StereoPoint>& left, const std::vector<PointFeature>& right,
                       const cv::Mat& left_image, const cv::Mat& right_image, const StereoOptions& options,
                       const RunBoth& run_both = RunInTurn);

}  // namespace plslam
