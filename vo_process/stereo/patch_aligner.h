// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "vo_process/stereo/halved_pair.h"
#include "vo_process/stereo/row_field.h"

namespace plslam::vo {

// Square patches of grey levels for alignment; used by patch_aligner.cpp, patch_tracker.cpp and slant_refiner.cpp
// only.

inline constexpr int kHalf = 5;
inline constexpr int kSide = 2 * kHalf + 1;
inline constexpr int kRow = 12;  // a row of the patch and one column of weight 0, for whole vector registers
inline constexpr int kPixels = kSide * kSide;
/// Grey levels; lower bound of quantisation and sensor noise.
inline constexpr double kMinNoise = 1.0;
/// Step in pixels of the patch below which the search has converged.
inline constexpr double kPatchConverged = 0.01;

/// Column-major, so one image row is one column here.
using Patch = Eigen::Array<float, kRow, kSide>;

inline float Dot(const Patch& a, const Patch& b) { return (a * b).sum(); }

inline void RemoveMean(Patch& p) {
  const float mean = p.sum() / kPixels;
  p.topRows<kSide>() -= mean;
}

/// Reads grey levels starting at column `u` and row `v`.
template <int Rows>
Eigen::Array<float, kRow, Rows> ReadRows(const cv::Mat& image, int u, int v) {
  std::array<uint8_t, kRow * Rows> bytes;
  for (int y = 0; y < Rows; ++y) std::copy_n(image.ptr<uint8_t>(v + y) + u, kRow, bytes.data() + y * kRow);
  Eigen::Array<float, kRow, Rows> pixels;
  // A single long loop, which compilers vectorise.
  std::copy(bytes.begin(), bytes.end(), pixels.data());
  return pixels;
}

struct PatchGradients {
  Patch pixels;
  Patch grad_u;
  Patch grad_v;
};

/// Reads pixels and their central differences. `center` must be at least kHalf + 2 from the border of the image.
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

/// Distance of a patch's centre from the border of an image: one pixel more than the patch, for gradients on the left,
/// interpolation and the idle column on the right.
inline constexpr double kPatchMargin = kHalf + 2;

inline bool IsInside(const cv::Mat& image, double u, double v, double margin = kPatchMargin) {
  return u >= margin && v >= margin && u <= image.cols - 1 - margin && v <= image.rows - 1 - margin;
}

/// Samples a patch centred at a fractional position, bilinearly. It must be inside (`IsInside`).
inline void SamplePatch(const cv::Mat& image, double u, double v, Patch& patch) {
  const int u0 = static_cast<int>(std::floor(u));
  const int v0 = static_cast<int>(std::floor(v));
  const auto fu = static_cast<float>(u - u0);
  const auto fv = static_cast<float>(v - v0);
  const auto here = ReadRows<kSide + 1>(image, u0 - kHalf, v0 - kHalf);
  const auto next = ReadRows<kSide + 1>(image, u0 + 1 - kHalf, v0 - kHalf);
  const Eigen::Array<float, kRow, kSide + 1> along = here + fu * (next - here);
  patch = along.leftCols<kSide>() + fv * (along.rightCols<kSide>() - along.leftCols<kSide>());
  patch.bottomRows<1>().setZero();
}

/// Alignment of the patch around a left pixel with the right image.
struct PatchAlignment {
  double disparity_px = 0.0;
  double sigma_disparity_px = 0.0;
  /// Change of the disparity per pixel to the right and downwards; 0 if it was not measured.
  Eigen::Vector2d disparity_slope = Eigen::Vector2d::Zero();
  /// Row in the right image minus row in the left, measured from the patches alone (0 for perfect rectification), and
  /// its standard deviation.
  double row_offset_px = 0.0;
  double sigma_row_px = 0.0;
  /// Normalised correlation of the patches, and contrast of the right relative to the left.
  double correlation = 0.0;
  double gain = 0.0;
};

/// Sub-pixel disparity by aligning 11x11 patches of a rectified pair, for any gain and offset of brightness between
/// the images (their exposures may differ).
///
/// Gauss-Newton on the shift of a fixed left patch (inverse compositional: the normal equations are built once). The
/// shift has a row component, predicted by `rows` with `sigma_row_px`, because no rectification is perfect and a
/// slanted edge would convert its error into disparity. The disparity's sigma is its marginal standard deviation, from
/// the residuals and the inverse Hessian. Patches of coarse features are taken from halved images.
class PatchAligner {
 public:
  /// `pair` must outlive the aligner.
  PatchAligner(const HalvedPair& pair, double sigma_row_px, const RowField& rows = {})
      : pair_(&pair), sigma_row_px_(sigma_row_px), rows_(rows) {}

  /// Aligns the patch at `left_px`, detected at a pixel size of `scale`, starting from `disparity_px`. Returns nullopt
  /// if the patch leaves an image, has no gradient along the row, does not converge, or moves more than 2.5 of its
  /// pixels from the start.
  std::optional<PatchAlignment> Align(const Eigen::Vector2d& left_px, double scale, double disparity_px) const;

 private:
  const HalvedPair* pair_;
  double sigma_row_px_;
  RowField rows_;
};

}  // namespace plslam::vo
