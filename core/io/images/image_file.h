// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include <opencv2/core/mat.hpp>

#include "core/ids/ids.h"

namespace plslam {

/// One stereo pair as recorded, not rectified. `right` is 8-bit like `left`, or a 16-bit depth map for RGB-D rigs.
struct StereoImages {
  FrameId frame_id = 0;
  int64_t t_ns = 0;
  cv::Mat left;
  cv::Mat right;
};

/// Width and height of an image.
struct ImageSize {
  int width_px = 0;
  int height_px = 0;
  bool operator==(const ImageSize&) const = default;
};

/// Larger images are rejected before they are decoded.
inline constexpr int kMaxImagePixels = 64 * 1024 * 1024;

/// Size of a PNG, JPEG or binary PGM image from its header; no pixel is decoded. Throws DatasetError.
ImageSize ReadImageSize(const std::string& path);

/// The value of 16 bits that is white, unless fewer bits are stored in them.
inline constexpr int kWhiteOf16Bits = 65535;
/// The largest value of 8, 10, 12, 14 or 16 bits, the fewest that hold the bright value (black images: of 16): cameras
/// store 10 and 12 bits in 16, which would be almost black if 65535 were white.
int WhiteLevel(int bright);

/// Reads an image as 8-bit grey. 16-bit values are scaled (`white` and above become 255, rounded), colour is weighted
/// as in ITU-R BT.601; both in integers. Without `white`, it is the `WhiteLevel` of this image; images of one sequence
/// should have one in common. `clipped`, if given, becomes the part of the pixels above `white`. Throws DatasetError if
/// the file is missing, truncated, no image, or not of the size `expected` (checked before decoding).
cv::Mat ReadGreyImage(const std::string& path, const ImageSize& expected, std::optional<int> white = std::nullopt,
                      double* clipped = nullptr);
/// Reads an image of any size.
cv::Mat ReadGreyImage(const std::string& path);

/// The same of the content of a file that is called `name` in errors: an image within another file.
cv::Mat DecodeGreyImage(const std::string& name, std::span<const uint8_t> file, const ImageSize& expected,
                        std::optional<int> white = std::nullopt, double* clipped = nullptr);

/// At most this part of an image is brighter than its bright value: hot pixels of the sensor.
inline constexpr double kHotPixels = 1e-3;
/// The bright value of an image of 16 bits, which all but hot pixels do not exceed, at least 1; 0 for one of 8, which
/// is not decoded. Throw like `ReadGreyImage`.
int BrightWideValue(const std::string& path, const ImageSize& expected);
int BrightWideValue(const std::string& name, std::span<const uint8_t> file, const ImageSize& expected);
int BrightWideValue(const cv::Mat& image);

/// Pixels of 8 or 16 bits, grey, BGR or BGRA, as `ReadGreyImage` makes them grey.
cv::Mat GreyPixels(const cv::Mat& image, int white = kWhiteOf16Bits, double* clipped = nullptr);

/// Reads a 16-bit single-channel image (depth map). Throws DatasetError like `ReadGreyImage`, and for other pixel
/// types.
cv::Mat ReadDepthImage(const std::string& path, const ImageSize& expected);

}  // namespace plslam
