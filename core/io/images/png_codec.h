// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// Decodes a PNG file (ISO/IEC 15948) by libpng, without conversion: 8 or 16 bits (fewer are widened); one channel of
/// grey, three of colour (BGR, also of a palette), four (BGRA) if the file has transparency: an alpha channel, also
/// beside grey, or transparent colours. Metadata are ignored. `size` is the size in the header, which the caller has
/// checked. Throws std::runtime_error with libpng's reason if the file is damaged, ends early or has another size.
cv::Mat DecodePng(std::span<const uint8_t> bytes, cv::Size size);

/// Encodes an image of 8 or 16 bits, with one, three (BGR) or four channels (BGRA), as a PNG file. `compression` is
/// zlib's level from 0 (none) to 9 (smallest); without it, the fastest for drawings: runs of equal differences to the
/// left. Throws std::invalid_argument for other images.
std::string EncodePng(const cv::Mat& image, std::optional<int> compression = std::nullopt);

/// Writes the image as PNG (`EncodePng`), completely or not at all (`WriteFileAtomically`). Throws std::runtime_error
/// if the file cannot be written, std::invalid_argument for an invalid image.
void WritePng(const std::string& path, const cv::Mat& image, std::optional<int> compression = std::nullopt);

}  // namespace plslam
