// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

namespace plslam {

/// Octave in which a corner that was found in `octave` from `then_m` away should be found from `now_m` away.
inline int ExpectedOctave(int octave, double then_m, double now_m, double scale_factor, int levels) {
  const double steps = std::log(then_m / now_m) / std::log(scale_factor);
  return std::clamp(octave + static_cast<int>(std::lround(steps)), 0, levels - 1);
}

}  // namespace plslam
