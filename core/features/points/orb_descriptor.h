// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/features/features.h"

namespace plslam {

/// Radius of the pixels around a corner that its orientation and descriptor may read.
inline constexpr int kOrbPatchRadius_px = 15;
inline constexpr int kOrbAngleBins = 32;

/// Returns the direction from (x, y) to the intensity centroid of the disc of radius 15 around it, in (-pi, pi] with y
/// down (Rublee 2011, §3.2). 0 if the patch has none. The disc must be inside the CV_8UC1 image.
float IntensityCentroidAngle(const cv::Mat& image, int x, int y);

/// Returns one of `kOrbAngleBins` equal bins, centred on the multiples of 2 pi / bins.
int AngleBin(float angle_rad);

/// One test of the pattern: whether the pixel at (x0, y0) is darker than the one at (x1, y1).
struct BriefTest {
  int8_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
using BriefPattern = std::array<BriefTest, 256>;

/// Returns the pattern rotated by an angle bin. Its 256 pairs are drawn from a seeded Gaussian (BRIEF's G-II, Calonder
/// 2010), all within the patch for every rotation.
const BriefPattern& TurnedPattern(int bin);

/// Steered BRIEF descriptors (Rublee 2011, §4) on blurred images.
class OrbDescriptor {
 public:
  /// Bit i of the result is test i at (x, y) rotated by `bin`. The patch must be inside the CV_8UC1 image.
  Descriptor Compute(const cv::Mat& blurred, int x, int y, int bin);

 private:
  void PrepareOffsets(size_t step);

  // Address offsets of the rotated patterns for images with this row step.
  size_t step_ = 0;
  std::vector<int> offsets_;
};

/// Applies a 7x7 Gaussian blur (sigma 2) in integers, the same on every machine; borders repeat the last pixel.
/// `blurred` must not be `image`.
void BlurForBrief(const cv::Mat& image, cv::Mat& blurred);

}  // namespace plslam
