// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// The pixels of a PNG file (ISO/IEC 15948) by libpng, as the file has them: 8 or 16 bits (fewer are widened); one
/// channel of grey, three of colour (BGR, also of a palette), four (BGRA) where the file has transparency: an alpha
/// channel, also beside grey, or transparent colours. Metadata is passed over. `size` is what the header says; the
/// caller has found it bearable. Throws std::runtime_error with libpng's reason where the file is damaged, ends early
/// or is of another size.
cv::Mat DecodePng(std::span<const uint8_t> bytes, cv::Size size);

/// An image of 8 or 16 bits, with one, three (BGR) or four channels (BGRA), as a PNG file. `compression` is zlib's
/// level from 0 (none) to 9 (smallest); without it, the fastest for drawings: runs of equal differences to the left.
/// Throws std::invalid_argument for other images.
std::string EncodePng(const cv::Mat& image, std::optional<int> compression = std::nullopt);

/// Writes the image as PNG (`EncodePng`), whole or not at all (`WriteFileAtomically`). Throws std::runtime_error
/// where the file cannot be written, std::invalid_argument where the image is none.
void WritePng(const std::string& path, const cv::Mat& image, std::optional<int> compression = std::nullopt);

}  // namespace plslam
