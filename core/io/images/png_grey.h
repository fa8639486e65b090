// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>

namespace plslam {

/// The pixels of a PNG file that datasets are made of, three times as fast as by libpng: 8 bits of grey, not
/// interlaced, nothing transparent. nullopt for every other file, and for one in which anything at all is out of
/// order: what libpng makes of that is decided there alone.
std::optional<cv::Mat> DecodeGreyPng(std::span<const uint8_t> file, cv::Size size);

}  // namespace plslam
