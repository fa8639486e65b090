// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// How alike two rectified images are along a segment of the left one and its counterpart in the right one, whose
/// columns are smaller by a disparity that runs evenly from `disparity_p_px` at p to `disparity_q_px` at q, and whose
/// rows are those of `rows`.
///
/// Zero-mean normalised correlation, -1..1, of strips a few pixels wide to each side of the edge, of the more similar
/// side: behind the edge of an object the background may differ. 0 where the strips leave the images.
double StripSimilarity(const cv::Mat& left_image, const cv::Mat& right_image, const Segment2& left,
                       double disparity_p_px, double disparity_q_px, const RowField& rows = {});

/// `lines` as stereo lines without depth, with `sigma_px` set from each one's length and contrast.
std::vector<StereoLine> WithoutDepth(std::vector<LineFeature> lines);

/// Finds the right segment of each left one and sets the disparities of its endpoints and their standard deviations
/// (PL-SLAM §IV.B).
///
/// Candidates must share rows with the left segment, run in nearly the same direction, be of similar length, imply
/// disparities in range at both ends, and have similar descriptors; the best must be best from both sides and clearly
/// better than the second, and the images must look alike along it. Without images (both empty) that last test is
/// left out; `rows` tells where in the right image the left rows are, while `right` has been brought to them.
/// Disparities are read where the right infinite line crosses the rows of the left endpoints, since detectors cut the
/// same edge at different places in the two images. Segments nearly parallel to the baseline, and those without a
/// match, keep negative disparities.
void MatchLinesStereo(std::vector<StereoLine>& left, const std::vector<LineFeature>& right, const cv::Mat& left_image,
                      const cv::Mat& right_image, const RowField& rows, const StereoOptions& options);

/// The same from a depth map aligned with the left image (16 bits, 0 = unknown): virtual disparities d = b f / Z of
/// the endpoints, from a robust straight fit of the inverse depths sampled along the segment. Too few known depths or
/// a break in them give no depth; segments parallel to the baseline do get theirs.
void AttachDepthToLines(std::vector<StereoLine>& lines, const cv::Mat& depth16, double depth_units_per_m,
                        const StereoCamera& camera, const StereoOptions& options);

}  // namespace plslam::vo
