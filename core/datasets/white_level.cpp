// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/white_level.h"

#include <algorithm>
#include <bit>
#include <stdexcept>

#include <fmt/format.h>

#include "core/io/images/image_file.h"

namespace plslam {

int WhiteLevelOf(int n_frames, const std::function<int(int frame)>& largest, Notes* notes) {
  constexpr int kQuarters = 4;
  int most = 0;
  for (int i = 0; i <= kQuarters; ++i) {
    try {
      const int value = largest(static_cast<int>(int64_t{n_frames - 1} * i / kQuarters));
      if (value == 0 && most == 0) return kWhiteOf16Bits;
      most = std::max(most, value);
    } catch (const std::runtime_error&) {
      continue;  // an error when it is played
    }
  }
  const int white = WhiteLevel(most);
  if (white < kWhiteOf16Bits) {
    notes->Remark(fmt::format("its 16-bit images have values up to {}, as with {} bits: {} is mapped to white", most,
                              std::bit_width(static_cast<unsigned>(white)), white));
  }
  return white;
}

}  // namespace plslam
