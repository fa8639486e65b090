// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/patch_aligner.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "vo_process/stereo/slant_refiner.h"

namespace plslam::vo {
namespace {

constexpr int kMaxAlignIterations = 8;
constexpr double kMaxAlignTravel = 2.5;
/// Above this most of the gradient is noise.
constexpr double kMaxInflation = 3.0;
/// Error that the residuals do not show, in pixels of the level: interpolation, surfaces that are not flat. Measured on
/// real pairs.
constexpr double kAlignModelError = 0.05;
/// Slant causes errors in proportion to the disparity; below this, other errors are larger.
constexpr double kMinSlantDisparity_px = 10.0;

/// The left patch prepared for Gauss-Newton: its pixels and gradients, made orthogonal to a constant, and the gradients
/// also to the pixels, which eliminates offset and gain of brightness from the equations for the shift.
struct Template : PatchGradients {
  double energy = 0.0;
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
};

Template MakeTemplate(const cv::Mat& image, const Eigen::Vector2i& center) {
  Template t{ReadGradients(image, center)};
  RemoveMean(t.pixels);
  RemoveMean(t.grad_u);
  RemoveMean(t.grad_v);
  const float energy = Dot(t.pixels, t.pixels);
  t.energy = energy;
  if (energy > 0.0F) {
    t.grad_u -= t.pixels * (Dot(t.grad_u, t.pixels) / energy);
    t.grad_v -= t.pixels * (Dot(t.grad_v, t.pixels) / energy);
  }
  const double uv = Dot(t.grad_u, t.grad_v);
  t.hessian << Dot(t.grad_u, t.grad_u), uv, uv, Dot(t.grad_v, t.grad_v);
  return t;
}

/// Result of comparing the left patch with one right patch.
struct PairComparison {
  double gain = 0.0;
  double correlation = 0.0;
  double noise = 0.0;  // residual standard deviation in grey levels of the left image
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
};

PairComparison Compare(const Template& t, const Patch& right) {
  PairComparison c;
  const double sum = right.sum();
  const double energy = Dot(right, right) - sum * sum / kPixels;
  const double cross = Dot(t.pixels, right);
  c.gain = cross / t.energy;
  if (!(energy > 0.0) || !(cross > 0.0)) return c;
  c.correlation = cross / std::sqrt(t.energy * energy);
  c.gradient = Eigen::Vector2d(Dot(t.grad_u, right), Dot(t.grad_v, right)) / c.gain;
  const double residual = energy / (c.gain * c.gain) - t.energy;
  c.noise = std::max(std::sqrt(std::max(residual, 0.0) / (kPixels - 4)), kMinNoise);
  return c;
}

/// Returns the ratio of the apparent to the true energy of the left patch's gradients, to which noise adds. Half of the
/// residual variance belongs to the left patch, and central differences halve it.
double NoiseInflation(double gradient_energy, double noise) {
  const double from_noise = 0.25 * noise * noise * kPixels;
  return gradient_energy > from_noise ? gradient_energy / (gradient_energy - from_noise) : kMaxInflation;
}

}  // namespace

std::optional<PatchAlignment> PatchAligner::Align(const Eigen::Vector2d& left_px, double scale,
                                                  double disparity_px) const {
  const HalvedPair::Level& level = pair_->LevelFor(scale);
  const double size_px = level.size_px;
  const Eigen::Vector2d left = level.FromImage(left_px);
  const int u = static_cast<int>(std::lround(left.x()));
  const int v = static_cast<int>(std::lround(left.y()));
  if (!IsInside(level.left, u, v)) return std::nullopt;
  const Template patch = MakeTemplate(level.left, {u, v});
  if (!(patch.energy > kPixels * kMinNoise * kMinNoise) || !(patch.hessian(0, 0) > 0.0)) return std::nullopt;

  const double start = disparity_px / size_px;
  const double row_information = size_px * size_px / (sigma_row_px_ * sigma_row_px_);
  const double expected_row = rows_.MatchOffset_px(left_px, disparity_px) / size_px;
  Eigen::Vector2d shift(-start, expected_row);
  Patch right;
  for (int iteration = 0; iteration < kMaxAlignIterations; ++iteration) {
    if (!IsInside(level.right, u + shift.x(), v + shift.y())) return std::nullopt;
    SamplePatch(level.right, u + shift.x(), v + shift.y(), right);
    const PairComparison c = Compare(patch, right);
    if (!(c.correlation > 0.0)) return std::nullopt;
    Eigen::Matrix2d hessian = patch.hessian;
    Eigen::Vector2d gradient = c.gradient;
    const double prior = c.noise * c.noise * row_information;
    hessian(1, 1) += prior;
    gradient.y() += prior * (shift.y() - expected_row);
    const double determinant = hessian.determinant();
    if (!(determinant > 1e-6 * hessian(0, 0) * hessian(1, 1))) return std::nullopt;
    const Eigen::Vector2d step = hessian.inverse() * gradient;
    shift -= step;
    if (!(std::abs(shift.x() + start) <= kMaxAlignTravel)) return std::nullopt;
    if (step.cwiseAbs().maxCoeff() > kPatchConverged) continue;
    const double inflation = NoiseInflation(hessian(0, 0), c.noise);
    if (!(inflation < kMaxInflation)) return std::nullopt;
    PatchAlignment found;
    found.disparity_px = -shift.x();
    found.correlation = c.correlation;
    found.gain = c.gain;
    // Measurement without the prior, which contributes to `shift`: seen = shift + prior / own * (shift - expected).
    const double own = std::max(patch.hessian.determinant() / patch.hessian(0, 0), 1e-9);
    found.row_offset_px = (shift.y() + prior / own * (shift.y() - expected_row)) * size_px;
    found.sigma_row_px = c.noise / std::sqrt(own) * size_px;
    double variance = c.noise * c.noise * hessian(1, 1) / determinant;
    const Eigen::Vector2d off_center = left - Eigen::Vector2d(u, v);
    std::optional<SlantedAlignment> slanted;
    if (found.disparity_px * size_px >= kMinSlantDisparity_px) {
      slanted = RefineSlanted(level, {u, v}, off_center, shift, {expected_row, row_information});
    }
    if (slanted) {
      found.disparity_px = -slanted->shift_u_px;
      found.disparity_slope = slanted->disparity_slope;
      found.correlation = slanted->correlation;
      variance = slanted->variance;
    }
    found.disparity_px *= size_px;
    found.sigma_disparity_px =
        std::sqrt(variance * inflation * inflation + kAlignModelError * kAlignModelError) * size_px;
    return found;
  }
  return std::nullopt;
}

}  // namespace plslam::vo
