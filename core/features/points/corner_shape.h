#pragma once

#include <opencv2/core/mat.hpp>

namespace plslam {

/// How well a 7x7 patch is fixed in both directions: smaller to larger eigenvalue of its summed gradient products, 0 for
/// a straight edge, 1 for the same gradients all round (Harris & Stephens 1988; the ratio is scale-free in contrast). A
/// "corner" that noise made on an edge slides along it, and its place means nothing there.
///
/// Gradients are central differences; (x, y) must be at least 4 pixels from the border of the CV_8UC1 image.
double CornerRatio(const cv::Mat& image, int x, int y);

}  // namespace plslam
