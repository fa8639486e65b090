#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <opencv2/core/mat.hpp>

namespace plslam {

/// Pixels of what cameras record: a grey PNG of 8 or 16 bits, not interlaced, of at most `max_pixels`. Same values as
/// libpng's, in a third of its time. nullopt where the bytes are another PNG or damaged; a general decoder knows which.
std::optional<cv::Mat> DecodeGreyPng(std::span<const uint8_t> bytes, int64_t max_pixels);

}  // namespace plslam
