#pragma once

#include <opencv2/core/mat.hpp>

#include "core/geometry/segment.h"
#include "vo_process/stereo/row_field.h"

namespace plslam {

/// How alike two rectified images are along a segment of the left one and its counterpart in the right one, whose
/// columns are smaller by a disparity that runs evenly from `disparity_p_px` at p to `disparity_q_px` at q, and whose rows are
/// those of `rows`.
///
/// Zero-mean normalised correlation, -1..1, of strips a few pixels wide to each side of the edge, of the more similar
/// side: behind the edge of an object the background may differ. 0 where the strips leave the images.
double StripSimilarity(const cv::Mat& left_image, const cv::Mat& right_image, const Segment2& left,
                       double disparity_p_px, double disparity_q_px, const RowField& rows = {});

}  // namespace plslam
