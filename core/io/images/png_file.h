// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

namespace plslam {

/// Writes the image as PNG (`EncodePng`), whole or not at all (`WriteFileAtomically`). Throws std::runtime_error
/// where the file cannot be written, std::invalid_argument where the image is none.
void WritePng(const std::string& path, const cv::Mat& image, std::optional<int> compression = std::nullopt);

}  // namespace plslam
