// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/images/png_grey.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include <libdeflate.h>
#include <opencv2/core/hal/intrin.hpp>

namespace plslam {
namespace {

// A pixel depends on the one to its left, so vectors cannot run along a row; and on the one above, so rows cannot be
// processed in parallel, unless each is one pixel behind the row above. Eight rows are processed in this way, a lane
// for each. OpenCV's vectors are used, since compilers generate many small steps for the shuffles of their own vector
// types.
constexpr int kLanes = 8;
using Lanes = cv::v_int16x8;
using TwoRows = cv::v_uint8x16;
/// Eight rows of eight bytes, two in each.
using Square = std::array<TwoRows, kLanes / 2>;

/// Rows to columns, by interleaving rows, then pairs, then fours of them.
Square Transposed(const Square& in) {
  std::array<cv::v_uint16x8, kLanes / 2> twos;
  for (size_t i = 0; i < in.size(); ++i) {
    TwoRows low;
    TwoRows high;
    cv::v_zip(in[i], cv::v_rotate_right<kLanes>(in[i]), low, high);
    twos[i] = cv::v_reinterpret_as_u16(low);
  }
  std::array<cv::v_uint16x8, kLanes / 2> fours;
  cv::v_zip(twos[0], twos[1], fours[0], fours[1]);
  cv::v_zip(twos[2], twos[3], fours[2], fours[3]);
  std::array<cv::v_uint32x4, kLanes / 2> out;
  cv::v_zip(cv::v_reinterpret_as_u32(fours[0]), cv::v_reinterpret_as_u32(fours[2]), out[0], out[1]);
  cv::v_zip(cv::v_reinterpret_as_u32(fours[1]), cv::v_reinterpret_as_u32(fours[3]), out[2], out[3]);
  return {cv::v_reinterpret_as_u8(out[0]), cv::v_reinterpret_as_u8(out[1]), cv::v_reinterpret_as_u8(out[2]),
          cv::v_reinterpret_as_u8(out[3])};
}

/// Eight rows with room on both sides: each begins up to seven pixels later than the first.
class RowBlock {
 public:
  explicit RowBlock(int width)
      : steps_((width + 2 * kLanes - 2) / kLanes * kLanes),
        stride_(static_cast<size_t>(steps_ + 2 * kLanes)),
        bytes_(stride_ * kLanes) {}

  /// Pixels of all rows, as many as a loop over complete squares covers.
  int steps() const { return steps_; }
  size_t stride() const { return stride_; }
  uint8_t* Row(int i) { return bytes_.data() + static_cast<size_t>(i) * stride_ + kLanes; }

  Square Load(int step) {
    const auto at = [this, step](int i) { return Row(i) + step - i; };
    return {cv::v_load_halves(at(0), at(1)), cv::v_load_halves(at(2), at(3)), cv::v_load_halves(at(4), at(5)),
            cv::v_load_halves(at(6), at(7))};
  }
  void Store(const Square& square, int step) {
    for (int i = 0; i < kLanes; i += 2) {
      const TwoRows& two = square[static_cast<size_t>(i) / 2];
      cv::v_store_low(Row(i) + step - i, two);
      cv::v_store_high(Row(i + 1) + step - i - 1, two);
    }
  }

 private:
  int steps_;
  size_t stride_;
  std::vector<uint8_t> bytes_;
};

/// Masks of the lanes whose row has the filter: pixel to the left, pixel above, their mean, and Paeth's.
class FilterMasks {
 public:
  /// Returns false for an invalid filter number.
  bool Set(int lane, uint8_t filter) {
    for (size_t i = 0; i < masks_.size(); ++i) masks_[i][static_cast<size_t>(lane)] = filter == i + 1 ? -1 : 0;
    return filter <= masks_.size();
  }
  Lanes left() const { return cv::v_load(masks_[0].data()); }
  Lanes above() const { return cv::v_load(masks_[1].data()); }
  Lanes mean() const { return cv::v_load(masks_[2].data()); }
  Lanes paeth() const { return cv::v_load(masks_[3].data()); }

 private:
  std::array<std::array<int16_t, kLanes>, 4> masks_{};
};

/// Returns the nearest of left, above and above left to left + above - above left; the first of two that are equally
/// near. If that sum lies beyond the larger of left and above, or below the smaller, the result is that one; between
/// them it is above left.
Lanes Paeth(const Lanes& left, const Lanes& above, const Lanes& above_left) {
  const Lanes low = cv::v_min(left, above);
  const Lanes high = cv::v_max(left, above);
  const Lanes threshold = above_left + above_left + above_left - (left + above);
  return cv::v_select(threshold > low, cv::v_select(high > threshold, above_left, low), high);
}

/// Takes the filters off pixel by pixel; in each lane one pixel of its row.
class Unfilter {
 public:
  explicit Unfilter(const FilterMasks& masks)
      : left_mask_(masks.left()), up_mask_(masks.above()), mean_mask_(masks.mean()), paeth_mask_(masks.paeth()) {}

  /// `above` ends with the pixel above that of the first lane.
  Lanes Next(const Lanes& filtered, const int16_t* above) {
    const Lanes corner = up_;
    up_ = cv::v_rotate_left<1>(left_, cv::v_load(above));
    const Lanes predicted = (left_ & left_mask_) | (up_ & up_mask_) | (((left_ + up_) >> 1) & mean_mask_) |
                            (Paeth(left_, up_, corner) & paeth_mask_);
    left_ = (filtered + predicted) & cv::v_setall_s16(255);
    return left_;
  }

 private:
  Lanes left_mask_, up_mask_, mean_mask_, paeth_mask_;
  Lanes left_ = cv::v_setzero_s16();
  Lanes up_ = cv::v_setzero_s16();
};

/// Works in place. `above` is the row above the first, after seven pixels of value 0.
void UnfilterBlock(const FilterMasks& masks, const int16_t* above, RowBlock& rows) {
  Unfilter unfilter(masks);
  for (int step = 0; step < rows.steps(); step += kLanes) {
    Square columns = Transposed(rows.Load(step));
    for (TwoRows& two : columns) {
      cv::v_uint16x8 first;
      cv::v_uint16x8 second;
      cv::v_expand(two, first, second);
      const Lanes first_done = unfilter.Next(cv::v_reinterpret_as_s16(first), above++);
      two = cv::v_pack_u(first_done, unfilter.Next(cv::v_reinterpret_as_s16(second), above++));
    }
    rows.Store(Transposed(columns), step);
  }
}

}  // namespace

bool TakeFiltersOff(const uint8_t* filtered, cv::Mat& out) {
  RowBlock rows(out.cols);
  std::vector<int16_t> above(rows.stride());
  FilterMasks masks;
  const auto width = static_cast<size_t>(out.cols);
  for (int y0 = 0; y0 < out.rows; y0 += kLanes) {
    const int n_rows = std::min(kLanes, out.rows - y0);
    for (int i = 0; i < n_rows; ++i) {
      if (!masks.Set(i, *filtered++)) return false;
      // Pixels of the previous block left of the row must count as 0.
      std::memset(rows.Row(i) - kLanes, 0, kLanes);
      std::memcpy(rows.Row(i), filtered, width);
      filtered += width;
    }
    UnfilterBlock(masks, above.data(), rows);
    for (int i = 0; i < n_rows; ++i) std::memcpy(out.ptr<uint8_t>(y0 + i), rows.Row(i), width);
    std::copy_n(rows.Row(kLanes - 1), width, above.data() + kLanes - 1);
  }
  return true;
}

namespace {

constexpr std::string_view kSignature = "\x89PNG\r\n\x1a\n";
/// Length, name and checksum of a chunk; the contents are between the last two.
constexpr size_t kChunkFrame = 12;
constexpr size_t kHeaderSize = 13;

uint32_t BigEndian(const uint8_t* bytes) {
  return uint32_t{bytes[0]} << 24 | uint32_t{bytes[1]} << 16 | uint32_t{bytes[2]} << 8 | uint32_t{bytes[3]};
}

struct Chunk {
  std::string_view name;
  std::span<const uint8_t> contents;
};

/// Removes the first chunk from `rest`; nullopt if it is truncated or its checksum is wrong.
std::optional<Chunk> TakeChunk(std::span<const uint8_t>& rest) {
  if (rest.size() < kChunkFrame) return std::nullopt;
  const size_t size = BigEndian(rest.data());
  if (size > rest.size() - kChunkFrame) return std::nullopt;
  const uint8_t* name = rest.data() + 4;
  if (libdeflate_crc32(0, name, size + 4) != BigEndian(name + 4 + size)) return std::nullopt;
  const Chunk chunk{{reinterpret_cast<const char*>(name), 4}, rest.subspan(8, size)};
  rest = rest.subspan(size + kChunkFrame);
  return chunk;
}

bool IsPlainGrey(const Chunk& header, cv::Size size) {
  // Bits, colour type, compression, filters, interlacing.
  constexpr std::array<uint8_t, 5> kPlainGrey = {8, 0, 0, 0, 0};
  return header.name == "IHDR" && header.contents.size() == kHeaderSize &&
         BigEndian(header.contents.data()) == static_cast<uint32_t>(size.width) &&
         BigEndian(header.contents.data() + 4) == static_cast<uint32_t>(size.height) &&
         std::memcmp(header.contents.data() + 8, kPlainGrey.data(), kPlainGrey.size()) == 0;
}

/// Returns whether the chunk is ancillary and does not change pixels as transparency does.
bool IsBeside(const Chunk& chunk) {
  constexpr char kAncillary = 0x20;
  return (chunk.name[0] & kAncillary) != 0 && chunk.name != "tRNS";
}

/// Returns the compressed pixels, which lie in consecutive chunks; nullopt if the file has another format or is
/// damaged.
std::optional<std::vector<uint8_t>> CompressedPixels(std::span<const uint8_t> file, cv::Size size) {
  if (file.size() < kSignature.size() || std::memcmp(file.data(), kSignature.data(), kSignature.size()) != 0) {
    return std::nullopt;
  }
  std::span<const uint8_t> rest = file.subspan(kSignature.size());
  const std::optional<Chunk> header = TakeChunk(rest);
  if (!header || !IsPlainGrey(*header, size)) return std::nullopt;
  std::vector<uint8_t> pixels;
  pixels.reserve(rest.size());
  bool is_behind = false;
  while (const std::optional<Chunk> chunk = TakeChunk(rest)) {
    if (chunk->name == "IEND") return pixels;
    if (chunk->name == "IDAT" && !is_behind) {
      pixels.insert(pixels.end(), chunk->contents.begin(), chunk->contents.end());
    } else if (IsBeside(*chunk)) {
      is_behind = !pixels.empty();
    } else {
      return std::nullopt;
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<cv::Mat> DecodeGreyPng(std::span<const uint8_t> file, cv::Size size) {
  const std::optional<std::vector<uint8_t>> compressed = CompressedPixels(file, size);
  if (!compressed) return std::nullopt;
  const std::unique_ptr<libdeflate_decompressor, decltype(&libdeflate_free_decompressor)> decompressor(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (!decompressor) return std::nullopt;
  const size_t filtered_size = (static_cast<size_t>(size.width) + 1) * static_cast<size_t>(size.height);
  const auto filtered = std::make_unique_for_overwrite<uint8_t[]>(filtered_size);
  // No address for the output size is passed: any other size is then an error.
  const libdeflate_result result = libdeflate_zlib_decompress(
      decompressor.get(), compressed->data(), compressed->size(), filtered.get(), filtered_size, nullptr);
  cv::Mat image(size, CV_8UC1);
  if (result != LIBDEFLATE_SUCCESS || !TakeFiltersOff(filtered.get(), image)) return std::nullopt;
  return image;
}

}  // namespace plslam
