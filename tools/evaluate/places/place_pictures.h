// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

#include "tools/evaluate/places/place_evaluation.h"

namespace plslam {

/// The similarity matrices of points, lines and both side by side (PL-SLAM fig. 5), 8-bit BGR: blue 0, red the
/// largest but the highest half per cent of all off-diagonal similarities, which the title of each names. Large
/// matrices are shrunk.
cv::Mat DrawSimilarities(const PlaceEvaluation& evaluation);

/// Precision over recall of the best matches (left) and of all pairs (right), a line for each merge.
cv::Mat DrawPrecisionRecall(const PlaceEvaluation& evaluation);

}  // namespace plslam
