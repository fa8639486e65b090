// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/image/linear_shrink.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/features/image/vector_kernels.h"

namespace plslam {
namespace {

constexpr int kWeightOne = 2048;
/// Bits dropped by the horizontal pass so that its result fits 16 bits.
constexpr int kDropped = 4;
/// Weights are split into multiples of this and a remainder.
constexpr int kLow = 32;
constexpr int kRowBlock = 32;

using Bytes = uint8_t __attribute__((vector_size(16)));
using Words = int16_t __attribute__((vector_size(16)));
using UnsignedWords = uint16_t __attribute__((vector_size(16)));

Bytes Pick(const Bytes& from, const Bytes& places) {
#if defined(__clang__)
  Bytes picked{};
  for (int i = 0; i < 16; ++i) picked[i] = from[places[i]];
  return picked;
#else
  return __builtin_shuffle(from, places);
#endif
}

template <class Vector>
Vector Load(const void* from) {
  Vector v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

/// Source position of a result pixel: the pixel before it, and the weight of the next one.
struct Place {
  int before;
  int weight;
};

Place SourcePlace(int i, int from, int to) {
  // Same precision and order of operations as OpenCV.
  const double scale = 1.0 / (static_cast<double>(to) / from);
  const auto place = static_cast<float>((i + 0.5) * scale - 0.5);
  const int before = static_cast<int>(std::floor(place));
  const float fraction = place - static_cast<float>(before);
  if (before < 0) return {0, 0};
  if (before >= from - 1) return {from - 1, 0};
  return {before, static_cast<int>(std::lrint(fraction * static_cast<float>(kWeightOne)))};
}

/// Blends two rows of the horizontal pass to pixels; weights sum to 2048.
PLSLAM_AVX2_CLONES
void BlendRows(const int16_t* first, const int16_t* second, int16_t first_weight, int16_t second_weight, int count,
               uint8_t* __restrict out) {
  for (int x = 0; x < count; ++x) {
    const auto a = static_cast<int16_t>((first[x] * first_weight) >> 16);
    const auto b = static_cast<int16_t>((second[x] * second_weight) >> 16);
    out[x] = static_cast<uint8_t>(static_cast<int16_t>(a + b + 2) >> 2);
  }
}

}  // namespace

bool LinearShrink::Fits(cv::Size from, cv::Size to) {
  return to.width >= kBlock && to.height >= kBlock && from.width >= to.width && from.height >= to.height &&
         from.width < 2 * to.width && from.height < 2 * to.height;
}

LinearShrink::LinearShrink(cv::Size from, cv::Size to) : from_(from), to_(to) {
  CV_Assert(Fits(from, to));
  for (int x = 0; x < to.width; x += kBlock) {
    Block block;
    // The last block overlaps the previous one.
    block.x = std::min(x, to.width - kBlock);
    block.source = std::clamp(SourcePlace(block.x, from.width, to.width).before, 0, std::max(0, from.width - kSpan));
    for (int i = 0; i < kBlock; ++i) {
      const Place place = SourcePlace(block.x + i, from.width, to.width);
      const int first = place.before - block.source;
      block.pick[2 * i] = static_cast<uint8_t>(first);
      block.pick[2 * i + 1] = static_cast<uint8_t>(std::min(first + 1, from.width - 1 - block.source));
      block.twice_high[i] = static_cast<int16_t>(2 * (place.weight / kLow));
      block.low[i] = static_cast<int16_t>(place.weight % kLow);
    }
    blocks_.push_back(block);
  }
  for (int y = 0; y < to.height; ++y) {
    const Place place = SourcePlace(y, from.height, to.height);
    rows_.push_back({place.before, std::min(place.before + 1, from.height - 1),
                     static_cast<int16_t>(kWeightOne - place.weight), static_cast<int16_t>(place.weight)});
  }
  for (auto& row : shrunk_) row.resize(static_cast<size_t>(to.width));
  if (from.width < kSpan) padded_.resize(kSpan);
}

/// (a (2048 - w) + b w) / 16 = 128 a + w (b - a) / 16. With w = 32 h + l this is 128 a + 2 h (b - a) + l (b - a) / 16,
/// in which nothing exceeds 16 bits.
PLSLAM_AVX2_CLONES
void LinearShrink::ShrinkRow(const std::vector<Block>& blocks, const uint8_t* source, int16_t* out) {
  for (const Block& block : blocks) {
    const auto pairs =
        reinterpret_cast<UnsignedWords>(Pick(Load<Bytes>(source + block.source), Load<Bytes>(block.pick)));
    const auto a = reinterpret_cast<Words>(pairs & 255);
    const Words d = reinterpret_cast<Words>(pairs >> 8) - a;
    const Words shrunk = 128 * a + d * Load<Words>(block.twice_high) + ((d * Load<Words>(block.low)) >> kDropped);
    std::memcpy(out + block.x, &shrunk, sizeof shrunk);
  }
}

const int16_t* LinearShrink::SourceRow(const cv::Mat& image, int y) {
  const int slot = y % 2;
  if (shrunk_row_[slot] != y) {
    const uint8_t* source = image.ptr<uint8_t>(y);
    if (!padded_.empty()) {
      std::copy_n(source, from_.width, padded_.begin());
      source = padded_.data();
    }
    ShrinkRow(blocks_, source, shrunk_[slot].data());
    shrunk_row_[slot] = y;
  }
  return shrunk_[slot].data();
}

void LinearShrink::Apply(const cv::Mat& image, cv::Mat& out) {
  CV_Assert(image.type() == CV_8UC1 && image.size() == from_);
  out.create(to_, CV_8UC1);
  std::fill_n(shrunk_row_, 2, -1);
  for (int y = 0; y < to_.height; ++y) {
    const Row& row = rows_[static_cast<size_t>(y)];
    const int16_t* first = SourceRow(image, row.first);
    const int16_t* second = SourceRow(image, row.second);
    auto* pixels = out.ptr<uint8_t>(y);
    InWholeBlocks<kRowBlock>(to_.width, [&](int begin, int n) {
      BlendRows(first + begin, second + begin, row.first_weight, row.second_weight, n, pixels + begin);
    });
  }
}

}  // namespace plslam
