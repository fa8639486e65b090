// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::test {

/// Variants of a PNG file.
struct PngKind {
  int colour_type = 0;  ///< of libpng: PNG_COLOR_TYPE_*
  int bits = 8;
  bool interlaced = false;
  bool transparent_colour = false;  ///< chunk tRNS
  bool gamma = false;               ///< chunks gAMA, cHRM and a text
  int width_px = 37;
  int height_px = 23;

  std::string Name() const;
};

/// All that the standard allows: each colour type with each of its depths, with and without the rest.
std::vector<PngKind> AllPngKinds();

/// Such a file of random pixels, written by libpng directly.
std::string MakePng(const PngKind& kind, unsigned seed);

}  // namespace plslam::test
