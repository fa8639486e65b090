// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>

#include <vector>

#include "core/features/features.h"
#include "core/features/options.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"
#include "vo_process/stereo/dirt_cells.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

/// Returns the similarity of two rectified images along a segment of the left one and its counterpart in the right one,
/// whose columns are smaller by a disparity that is linear from `disparity_p_px` at p to `disparity_q_px` at q, and
/// whose rows differ by `rows`.
///
/// Zero-mean normalised correlation, -1..1, of strips a few pixels wide on each side of the edge; that of the more
/// similar side, because the background of an object edge may differ. Leaves out places on dirt. 0 if few places remain
/// within the images.
double StripSimilarity(const cv::Mat& left_image, const cv::Mat& right_image, const Segment2& left,
                       double disparity_p_px, double disparity_q_px, const RowField& rows = {},
                       const PairDirt& dirt = {});

/// Returns `lines` as stereo lines without depth, with `sigma_px` from the length and contrast of each.
std::vector<StereoLine> WithoutDepth(std::vector<LineFeature> lines);

/// Finds the right segment of each left one and sets the disparities of its endpoints and their standard deviations
/// (PL-SLAM §IV.B).
///
/// Candidates must share rows with the left segment, have a similar direction and length, disparities in range at both
/// ends, and similar descriptors; the best must be mutual and clearly better than the second, and the images must be
/// similar along it. Without images (both empty) the last test is skipped; `rows` maps left rows to the right image,
/// while `right` has already been corrected to left rows. Disparities are measured where the infinite right line
/// crosses the rows of the left endpoints, because detectors cut the same edge differently in the two images. Segments
/// nearly parallel to the baseline, and those without a match, keep negative disparities.
///
/// Dirt changes descriptors of the lines that cross it. Where these find no match, the candidate along which the images
/// are clearly most similar beside the dirt is taken.
void MatchLinesStereo(std::vector<StereoLine>& left, const std::vector<LineFeature>& right, const cv::Mat& left_image,
                      const cv::Mat& right_image, const RowField& rows, const StereoOptions& options,
                      const PairDirt& dirt = {});

/// Sets the depth of a segment from its known counterpart in the right image, as measured there; none if its disparities
/// would be too uncertain or out of range, or if the images differ along it.
void SetDepthFromRight(const LineFeature& right, const cv::Mat& left_image, const cv::Mat& right_image,
                       const RowField& rows, const StereoOptions& options, const PairDirt& dirt, StereoLine& line);

/// The same from a depth map aligned with the left image (16 bits, 0 = unknown): virtual disparities d = b f / Z of
/// the endpoints, from a robust linear fit of the inverse depths sampled along the segment. Segments with too few known
/// depths or a discontinuity get no depth; segments parallel to the baseline do get one.
void AttachDepthToLines(std::vector<StereoLine>& lines, const cv::Mat& depth16, double depth_units_per_m,
                        const StereoCamera& camera, const StereoOptions& options);

}  // namespace plslam::vo
