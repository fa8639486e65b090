// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core.hpp>

#include "tools/evaluate/places/place_evaluation.h"

namespace plslam {

/// The similarity that is drawn as white: the largest but the highest half per cent of all off-diagonal ones; 1
/// without any.
float FullScale(const SimilarityMatrix& matrix);

/// A pixel for each pair, 8 bits, `scale` and above white.
cv::Mat GreySimilarities(const SimilarityMatrix& matrix, float scale);

}  // namespace plslam
