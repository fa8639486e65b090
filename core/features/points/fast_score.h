// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

namespace plslam {

inline constexpr int kFastRadius_px = 3;

/// Computes the FAST-9 score of every pixel of a CV_8UC1 image (Rosten 2006): the largest t for which 9 consecutive
/// neighbours on the circle of 16 are all at least t brighter, or all at least t darker, than the centre. 0 within 3
/// pixels of the border.
///
/// A dense map costs less than a list: without branches it processes 32 pixels at a time, and serves any threshold.
void FastScores(const cv::Mat& image, cv::Mat& scores);

/// Keeps scores that are at least `min_score` and local maxima of their 3x3 neighbourhood; others become 0. The last of
/// equal neighbours in reading order is kept.
void SuppressNonMaxima(const cv::Mat& scores, int min_score, cv::Mat& maxima);

}  // namespace plslam
