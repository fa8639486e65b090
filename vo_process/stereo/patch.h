// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace plslam {

// Square patches of grey levels for alignment; used by patch_aligner.cpp, patch_tracker.cpp and slant_refiner.cpp
// only.

inline constexpr int kHalf = 5;
inline constexpr int kSide = 2 * kHalf + 1;
inline constexpr int kRow = 12;  // a row of the patch and one column of weight 0, for whole vector registers
inline constexpr int kPixels = kSide * kSide;
/// Grey levels; quantisation and sensor noise hardly go below this.
inline constexpr double kMinNoise = 1.0;
/// Steps below this, in pixels of the patch, end a search.
inline constexpr double kPatchConverged = 0.01;

/// Column-major, so one image row is one column here.
using Patch = Eigen::Array<float, kRow, kSide>;

inline float Dot(const Patch& a, const Patch& b) { return (a * b).sum(); }

inline void RemoveMean(Patch& p) {
  const float mean = p.sum() / kPixels;
  p.topRows<kSide>() -= mean;
}

/// Grey levels from column `u` and row `v` on.
template <int Rows>
Eigen::Array<float, kRow, Rows> ReadRows(const cv::Mat& image, int u, int v) {
  std::array<uint8_t, kRow * Rows> bytes;
  for (int y = 0; y < Rows; ++y) std::copy_n(image.ptr<uint8_t>(v + y) + u, kRow, bytes.data() + y * kRow);
  Eigen::Array<float, kRow, Rows> pixels;
  // In one loop, long enough for compilers to use vector registers.
  std::copy(bytes.begin(), bytes.end(), pixels.data());
  return pixels;
}

struct PatchGradients {
  Patch pixels;
  Patch grad_u;
  Patch grad_v;
};

/// Pixels and their central differences. `center` must be at least kHalf + 2 from the border of the image.
inline PatchGradients ReadGradients(const cv::Mat& image, const Eigen::Vector2i& center) {
  const int u = center.x() - kHalf;
  const int v = center.y() - kHalf;
  const auto rows = ReadRows<kSide + 2>(image, u, v - 1);
  PatchGradients patch;
  patch.pixels = rows.middleCols<kSide>(1);
  patch.grad_u = 0.5F * (ReadRows<kSide>(image, u + 1, v) - ReadRows<kSide>(image, u - 1, v));
  patch.grad_v = 0.5F * (rows.rightCols<kSide>() - rows.leftCols<kSide>());
  for (Patch* p : {&patch.pixels, &patch.grad_u, &patch.grad_v}) p->bottomRows<1>().setZero();
  return patch;
}

}  // namespace plslam
