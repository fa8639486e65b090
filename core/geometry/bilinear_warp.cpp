// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/bilinear_warp.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>

namespace plslam {
namespace {

constexpr int kBlock = 64;

using Pairs = std::array<uint16_t, kBlock>;

uint16_t LoadPair(const uint8_t* pixel) {
  uint16_t pair = 0;
  std::memcpy(&pair, pixel, sizeof pair);
  return pair;
}

/// (32 (1 - wy) (a (1 - wx) + b wx) + ... + 512) / 1024, rounded down, in 16-bit steps: the weighted vertical
/// difference is divided by 32 first, which gives the same result after rounding down twice.
uint8_t Blend(uint16_t above, uint16_t below, int wx, int wy) {
  const auto first = [](uint16_t pair) { return static_cast<int16_t>(pair & 255); };
  const auto second = [](uint16_t pair) { return static_cast<int16_t>(pair >> 8); };
  const auto top = static_cast<int16_t>(32 * first(above) + wx * (second(above) - first(above)));
  const auto bottom = static_cast<int16_t>(32 * first(below) + wx * (second(below) - first(below)));
  // High half of a 16-bit product: (512 wy) (4 d) / 2^16 = wy d / 32.
  const auto weight = static_cast<int16_t>(512 * wy);
  const auto difference = static_cast<int16_t>(4 * (bottom - top));
  const auto share = static_cast<int16_t>((weight * difference) >> 16);
  return static_cast<uint8_t>(static_cast<int16_t>(top + share + 16) >> 5);
}

}  // namespace

BilinearWarp::BilinearWarp(cv::Size source, cv::Size result)
    : source_(source),
      result_(result),
      offsets_(static_cast<size_t>(result.width) * result.height, 0),
      weights_(offsets_.size(), Weights{0, 0}),
      mask_(offsets_.size(), 0) {
  const cv::Size least(std::min(source.width, result.width), std::min(source.height, result.height));
  if (least.width < 2 || least.height < 2) {
    throw std::runtime_error("images of " + std::to_string(least.width) + "x" + std::to_string(least.height) +
                             " cannot be warped, expected at least 2x2");
  }
}

void BilinearWarp::SetSource(int u, int v, int x, int y) {
  // The last column (row) is the right (lower) one of the last pair, so nothing is read outside the image.
  const int left = std::min(x / kSubpixels, source_.width - 2);
  const int top = std::min(y / kSubpixels, source_.height - 2);
  const size_t at = static_cast<size_t>(v) * result_.width + u;
  offsets_[at] = top * source_.width + left;
  weights_[at] = {static_cast<uint8_t>(x - left * kSubpixels), static_cast<uint8_t>(y - top * kSubpixels)};
  mask_[at] = 255;
}

void BilinearWarp::WarpRow(const uint8_t* image, int v, uint8_t* out) const {
  const size_t row = static_cast<size_t>(v) * result_.width;
  for (int u = 0; u < result_.width; u += kBlock) {
    const int count = std::min(kBlock, result_.width - u);
    const int32_t* offsets = offsets_.data() + row + u;
    const Weights* weights = weights_.data() + row + u;
    const uint8_t* mask = mask_.data() + row + u;
    Pairs above;
    Pairs below;
    for (int i = 0; i < count; ++i) {
      const uint8_t* pixel = image + offsets[i];
      above[i] = LoadPair(pixel);
      below[i] = LoadPair(pixel + source_.width);
    }
    // Separate from the loop above, whose addresses are scattered, so that this one is vectorised.
    for (int i = 0; i < count; ++i) {
      out[u + i] = static_cast<uint8_t>(Blend(above[i], below[i], weights[i].x, weights[i].y) & mask[i]);
    }
  }
}

cv::Mat BilinearWarp::Apply(const cv::Mat& image) const {
  CV_Assert(image.type() == CV_8UC1 && image.size() == source_);
  const cv::Mat whole = image.isContinuous() ? image : image.clone();
  cv::Mat result(result_, CV_8UC1);
  for (int v = 0; v < result_.height; ++v) WarpRow(whole.ptr<uint8_t>(), v, result.ptr<uint8_t>(v));
  return result;
}

}  // namespace plslam
