#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace plslam {

/// Writes the image as PNG, whole or not at all (`WriteFileAtomically`). `parameters` are those of cv::imencode. Throws
/// std::runtime_error where the file cannot be written, cv::Exception where the image is none.
void WritePng(const std::string& path, const cv::Mat& image, const std::vector<int>& parameters = {});

}  // namespace plslam
