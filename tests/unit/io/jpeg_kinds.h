// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::test {

/// Variants of a JPEG file.
struct JpegKind {
  std::string name;
  /// Of libjpeg: J_COLOR_SPACE of the pixels that are written and of those in the file.
  int pixels = 1;
  int stored = 1;
  int components = 1;
  int sampling = 1;  ///< colour is halved in width where 2, in height too where 4
  bool progressive = false;
  bool arithmetic = false;
  bool optimised = false;
  int restart_rows = 0;
  int orientation = 0;          ///< of an Exif block; 0: none
  bool without_tables = false;  ///< of Huffman, as in films of motion JPEG
  int quality = 90;
};

/// Grey, colour in all usual samplings, RGB, CMYK and YCCK; baseline, progressive, arithmetic.
std::vector<JpegKind> AllJpegKinds();

/// Such a file of blots and noise, written by libjpeg directly.
std::string MakeJpeg(const JpegKind& kind, int width_px, int height_px, unsigned seed);

}  // namespace plslam::test
