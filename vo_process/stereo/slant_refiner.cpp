// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/slant_refiner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <Eigen/Cholesky>

#include "vo_process/stereo/patch_aligner.h"

namespace plslam::vo {
namespace {

constexpr double kSlopeSigma = 0.2;
constexpr double kMaxSlope = 0.7;
// Slopes of noisy patches converge more slowly than shifts. With six iterations, one in ten patches of a noisy road did
// not converge, and fell back to a single shift.
constexpr int kMaxSlantIterations = 10;
constexpr double kMaxSlantTravel = 1.5;

constexpr size_t kPatchPlaces = static_cast<size_t>(kRow) * kSide;
using PatchRow = Eigen::Array<float, kRow, 1>;
/// The columns of a patch; the idle one repeats the last.
const PatchRow kColumns = PatchRow::LinSpaced(0.0F, kSide).min(kSide - 1);

/// Derivatives of the left patch by shift, row offset and slopes; orthogonal to a constant and to the patch itself,
/// which eliminates offset and gain of brightness.
struct SlantTemplate {
  Patch pixels;
  std::array<Patch, 4> derivatives;
  double energy = 0.0;
  Eigen::Matrix4d hessian;
};

SlantTemplate MakeTemplate(const cv::Mat& image, const Eigen::Vector2i& center) {
  const PatchGradients patch = ReadGradients(image, center);
  SlantTemplate t;
  t.pixels = patch.pixels;
  t.derivatives[0] = patch.grad_u;
  t.derivatives[1] = patch.grad_v;
  t.derivatives[2] = patch.grad_u.colwise() * (kColumns - kHalf);
  for (int y = 0; y < kSide; ++y) t.derivatives[3].col(y) = patch.grad_u.col(y) * static_cast<float>(y - kHalf);
  RemoveMean(t.pixels);
  const float energy = Dot(t.pixels, t.pixels);
  t.energy = energy;
  for (Patch& derivative : t.derivatives) {
    RemoveMean(derivative);
    derivative -= t.pixels * (Dot(derivative, t.pixels) / energy);
  }
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k <= i; ++k) t.hessian(i, k) = t.hessian(k, i) = Dot(t.derivatives[i], t.derivatives[k]);
  }
  return t;
}

/// Pixels of the image, each with its right neighbour.
using PixelPairs = std::array<uint8_t, 2 * kPatchPlaces>;

/// Interpolates linearly between the two pixels.
Patch Between(const PixelPairs& pairs, const Patch& fractions) {
  Patch patch;
  for (size_t i = 0; i < kPatchPlaces; ++i) {
    const auto here = static_cast<float>(pairs[2 * i]);
    const auto next = static_cast<float>(pairs[2 * i + 1]);
    patch.data()[i] = here + fractions.data()[i] * (next - here);
  }
  return patch;
}

/// Samples the right image at the warped left patch. Returns false if that leaves the image.
///
/// Only fetching pixels is scalar; positions and interpolation are vectorised loops over the whole patch.
bool Sample(const cv::Mat& image, const Eigen::Vector2i& center, const Eigen::Vector4d& warp, Patch& patch) {
  const auto step = static_cast<float>(1.0 + warp(2));
  const int reach = static_cast<int>(std::ceil((kSide - 1) * step)) + 2;
  std::array<const uint8_t*, kSide> rows;
  std::array<float, kSide> fv;
  Patch places;
  for (int y = 0; y < kSide; ++y) {
    const double v = center.y() + warp(1) + y - kHalf;
    const double u = center.x() + warp(0) + warp(3) * (y - kHalf) - (1.0 + warp(2)) * kHalf;
    const int v0 = static_cast<int>(std::floor(v));
    const int u0 = static_cast<int>(std::floor(u));
    if (v0 < 0 || v0 + 1 >= image.rows || u0 < 0 || u0 + reach >= image.cols) return false;
    rows[y] = image.ptr<uint8_t>(v0) + u0;
    fv[y] = static_cast<float>(v - v0);
    places.col(y) = static_cast<float>(u - u0) + step * kColumns;
  }
  std::array<int32_t, kPatchPlaces> columns;
  Patch fractions;
  for (size_t i = 0; i < kPatchPlaces; ++i) {
    columns[i] = static_cast<int32_t>(places.data()[i]);
    fractions.data()[i] = places.data()[i] - static_cast<float>(columns[i]);
  }
  PixelPairs above;
  PixelPairs below;
  for (size_t y = 0; y < kSide; ++y) {
    for (size_t i = y * kRow; i < (y + 1) * kRow; ++i) {
      std::memcpy(&above[2 * i], rows[y] + columns[i], 2);
      std::memcpy(&below[2 * i], rows[y] + image.step + columns[i], 2);
    }
  }
  const Patch top = Between(above, fractions);
  const Patch bottom = Between(below, fractions);
  for (int y = 0; y < kSide; ++y) patch.col(y) = top.col(y) + fv[y] * (bottom.col(y) - top.col(y));
  patch.bottomRows<1>().setZero();
  return true;
}

}  // namespace

std::optional<SlantedAlignment> RefineSlanted(const HalvedPair::Level& level, const Eigen::Vector2i& center,
                                              const Eigen::Vector2d& off_center, const Eigen::Vector2d& shift,
                                              const RowPrior& row) {
  const SlantTemplate t = MakeTemplate(level.left, center);
  Eigen::Vector4d warp(shift.x(), shift.y(), 0.0, 0.0);
  const Eigen::Vector4d place(1.0, 0.0, off_center.x(), off_center.y());
  const Eigen::Vector4d expected(0.0, row.offset_px, 0.0, 0.0);
  const Eigen::Vector4d prior(0.0, row.information, 1.0 / (kSlopeSigma * kSlopeSigma),
                              1.0 / (kSlopeSigma * kSlopeSigma));
  Patch right;
  for (int iteration = 0; iteration < kMaxSlantIterations; ++iteration) {
    if (!Sample(level.right, center, warp, right)) return std::nullopt;
    const double sum = right.sum();
    const double energy = Dot(right, right) - sum * sum / kPixels;
    const double gain = Dot(t.pixels, right) / t.energy;
    if (!(energy > 0.0) || !(gain > 0.0)) return std::nullopt;
    const double residual = std::max(energy / (gain * gain) - t.energy, 0.0);
    const double noise = std::max(std::sqrt(residual / (kPixels - 6)), kMinNoise);
    Eigen::Vector4d gradient;
    for (int i = 0; i < 4; ++i) gradient(i) = Dot(t.derivatives[i], right) / gain;
    const Eigen::Vector4d weight = noise * noise * prior;
    gradient += weight.cwiseProduct(warp - expected);
    const Eigen::Matrix4d hessian = t.hessian + Eigen::Matrix4d(weight.asDiagonal());
    const Eigen::LDLT<Eigen::Matrix4d> solver(hessian);
    const Eigen::Vector4d step = solver.solve(gradient);
    warp -= step;
    const bool sane =
        std::abs(warp(0) - shift.x()) <= kMaxSlantTravel && warp.tail<2>().cwiseAbs().maxCoeff() <= kMaxSlope;
    if (!sane) return std::nullopt;
    if (std::abs(step(0)) > kPatchConverged || step.tail<2>().cwiseAbs().maxCoeff() * kHalf > 5.0 * kPatchConverged)
      continue;
    return SlantedAlignment{place.dot(warp), -warp.tail<2>(), noise * noise * place.dot(solver.solve(place)),
                            std::sqrt(t.energy / (t.energy + residual))};
  }
  return std::nullopt;
}

}  // namespace plslam::vo
