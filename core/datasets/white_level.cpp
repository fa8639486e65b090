// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/white_level.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include <fmt/format.h>

#include "core/files/dataset_error.h"
#include "core/io/images/image_file.h"

namespace plslam {
namespace {

int BitsOf(int white) { return std::bit_width(static_cast<unsigned>(white)); }

}  // namespace

int WhiteLevelOf(int n_frames, const std::function<BrightValues(int frame)>& bright_of, Notes* notes) {
  constexpr int kMostSampled = 16;
  const int n = std::min(n_frames, kMostSampled);
  int most = 0;
  for (int i = 0; i < n && most < kWhiteOf16Bits; ++i) {
    const int frame = n == 1 ? 0 : static_cast<int>(int64_t{n_frames - 1} * i / (n - 1));
    BrightValues bright;
    try {
      bright = bright_of(frame);
    } catch (const std::runtime_error&) {
      continue;  // an error when it is played
    }
    if ((bright.left == 0) != (bright.right == 0)) {
      throw DatasetError(fmt::format(
          "the left image of frame {} has {} bits a pixel, and the right one {}: convert both in the same way", frame,
          bright.left == 0 ? 8 : 16, bright.right == 0 ? 8 : 16));
    }
    if (bright.left == 0 && most == 0) return kWhiteOf16Bits;
    most = std::max({most, bright.left, bright.right});
  }
  const int white = WhiteLevel(most);
  if (white < kWhiteOf16Bits) {
    notes->Remark(fmt::format("its 16-bit images have values up to {}, as with {} bits: {} is mapped to white", most,
                              BitsOf(white), white));
  }
  return white;
}

void ClippedFrames::Add(int frame, double clipped_left, double clipped_right) {
  if (std::max(clipped_left, clipped_right) <= kHotPixels) return;
  int none = -1;
  first_.compare_exchange_strong(none, frame);
  ++n_;
}

Notes ClippedFrames::Report() const {
  Notes notes;
  const int64_t n = n_;
  if (n == 0) return notes;
  notes.Warn(fmt::format(
      "{} frame{} so far {} values above {}, which is taken as the white of {} bits, and {} clipped (the "
      "first is frame {}): convert the images to 8 bits with one scale",
      n, n == 1 ? "" : "s", n == 1 ? "has" : "have", white_, BitsOf(white_), n == 1 ? "is" : "are", first_.load()));
  return notes;
}

}  // namespace plslam
