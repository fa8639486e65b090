// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace plslam {

enum class ImageFormat { kPng, kJpeg, kPgm };

/// Content of the first bytes of an image file.
struct ImageHeader {
  ImageFormat format = ImageFormat::kPng;
  int64_t width_px = 0;
  int64_t height_px = 0;
  /// PGM only: largest grey value, and where the pixels begin.
  int max_value = 0;
  size_t data_offset = 0;
  /// Bits of a value: 1 to 16.
  int bits = 8;
};

/// Parses the header of a PNG (ISO/IEC 15948), JPEG (ITU-T T.81, any frame type) or binary PGM ("P5") file, so that the
/// size is known before a decoder allocates memory. Returns nullopt if the bytes are none of them or end too early.
std::optional<ImageHeader> ParseImageHeader(std::span<const uint8_t> bytes);

/// Returns whether the file reaches the end mark of its format (PNG: chunk IEND; JPEG: marker EOI; PGM: all pixels).
/// Decoders fill the missing part of a truncated JPEG with grey, without an error.
bool IsComplete(const ImageHeader& header, std::span<const uint8_t> bytes);

}  // namespace plslam
