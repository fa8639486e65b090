#include "core/features/slant_refiner.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Cholesky>

#include "core/features/patch.h"

namespace plslam {
namespace {

constexpr double kSlopeSigma = 0.2;
constexpr double kMaxSlope = 0.7;
// Slopes of noisy patches take longer to settle than shifts. With six, one in ten patches of a noisy road did not, and fell
// back to one shift.
constexpr int kMaxSlantIterations = 10;
constexpr double kMaxSlantTravel = 1.5;

/// Derivatives of the left patch by shift, row offset and slopes; orthogonal to a constant and to the patch itself, so
/// that offset and gain of brightness drop out.
struct SlantTemplate {
  Patch pixels;
  std::array<Patch, 4> derivatives;
  double energy = 0.0;
  Eigen::Matrix4d hessian;
};

SlantTemplate MakeTemplate(const cv::Mat& image, const Eigen::Vector2i& center) {
  SlantTemplate t;
  t.pixels.setZero();
  for (Patch& derivative : t.derivatives) derivative.setZero();
  for (int y = 0; y < kSide; ++y) {
    const int v = center.y() + y - kHalf;
    const int u = center.x() - kHalf;
    const uint8_t* above = image.ptr<uint8_t>(v - 1) + u;
    const uint8_t* row = image.ptr<uint8_t>(v) + u;
    const uint8_t* below = image.ptr<uint8_t>(v + 1) + u;
    for (int x = 0; x < kSide; ++x) {
      const float along = 0.5F * static_cast<float>(row[x + 1] - row[x - 1]);
      t.pixels(x, y) = row[x];
      t.derivatives[0](x, y) = along;
      t.derivatives[1](x, y) = 0.5F * static_cast<float>(below[x] - above[x]);
      t.derivatives[2](x, y) = along * static_cast<float>(x - kHalf);
      t.derivatives[3](x, y) = along * static_cast<float>(y - kHalf);
    }
  }
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

/// Pixels of one image row at `columns` and, one further, `next`; nothing in the idle column.
struct Neighbours {
  std::array<int32_t, kRow> here{};
  std::array<int32_t, kRow> next{};

  void Take(const uint8_t* row, const std::array<int32_t, kRow>& columns) {
    for (size_t x = 0; x < kSide; ++x) {
      here[x] = row[columns[x]];
      next[x] = row[columns[x] + 1];
    }
  }
  float Between(size_t x, float f) const {
    const auto a = static_cast<float>(here[x]);
    return a + f * (static_cast<float>(next[x]) - a);
  }
};

/// The right image where the left patch should be. False where that leaves the image.
///
/// Only fetching pixels goes one by one; places and blending are loops over whole vector registers.
bool Sample(const cv::Mat& image, const Eigen::Vector2i& center, const Eigen::Vector4d& warp, Patch& patch) {
  const auto step = static_cast<float>(1.0 + warp(2));
  const int reach = static_cast<int>(std::ceil((kSide - 1) * step)) + 2;
  Neighbours above, below;
  for (int y = 0; y < kSide; ++y) {
    const double v = center.y() + warp(1) + y - kHalf;
    const double u = center.x() + warp(0) + warp(3) * (y - kHalf) - (1.0 + warp(2)) * kHalf;
    const int v0 = static_cast<int>(std::floor(v));
    const int u0 = static_cast<int>(std::floor(u));
    if (v0 < 0 || v0 + 1 >= image.rows || u0 < 0 || u0 + reach >= image.cols) return false;
    const auto fv = static_cast<float>(v - v0);
    const auto fu = static_cast<float>(u - u0);
    std::array<int32_t, kRow> columns;
    std::array<float, kRow> fractions;
    for (size_t x = 0; x < kRow; ++x) {
      const float place = fu + step * static_cast<float>(static_cast<int32_t>(x));
      columns[x] = static_cast<int32_t>(place);
      fractions[x] = place - static_cast<float>(columns[x]);
    }
    above.Take(image.ptr<uint8_t>(v0) + u0, columns);
    below.Take(image.ptr<uint8_t>(v0 + 1) + u0, columns);
    float* const out = &patch(0, y);
    for (size_t x = 0; x < kRow; ++x) {
      const float top = above.Between(x, fractions[x]);
      const float bottom = below.Between(x, fractions[x]);
      out[x] = top + fv * (bottom - top);
    }
  }
  return true;
}

}  // namespace

std::optional<SlantedAlignment> RefineSlanted(const HalvedPair::Level& level, const Eigen::Vector2i& center,
                                              const Eigen::Vector2d& off_center, const Eigen::Vector2d& shift,
                                              double row_information) {
  const SlantTemplate t = MakeTemplate(level.left, center);
  Eigen::Vector4d warp(shift.x(), shift.y(), 0.0, 0.0);
  const Eigen::Vector4d place(1.0, 0.0, off_center.x(), off_center.y());
  const Eigen::Vector4d prior(0.0, row_information, 1.0 / (kSlopeSigma * kSlopeSigma),
                              1.0 / (kSlopeSigma * kSlopeSigma));
  Patch right;
  right.setZero();
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
    gradient += weight.cwiseProduct(warp);
    const Eigen::Matrix4d hessian = t.hessian + Eigen::Matrix4d(weight.asDiagonal());
    const Eigen::LDLT<Eigen::Matrix4d> solver(hessian);
    const Eigen::Vector4d step = solver.solve(gradient);
    warp -= step;
    const bool sane =
        std::abs(warp(0) - shift.x()) <= kMaxSlantTravel && warp.tail<2>().cwiseAbs().maxCoeff() <= kMaxSlope;
    if (!sane) return std::nullopt;
    if (std::abs(step(0)) > kPatchConverged || step.tail<2>().cwiseAbs().maxCoeff() * kHalf > 5.0 * kPatchConverged)
      continue;
    const Eigen::Matrix4d P = solver.solve(Eigen::Matrix4d::Identity()) * (noise * noise);
    const Eigen::Vector2d information(1.0 / P(2, 2), 1.0 / P(3, 3));
    return SlantedAlignment{place.dot(warp), noise * noise * place.dot(solver.solve(place)),
                            std::sqrt(t.energy / (t.energy + residual)), warp.tail<2>(), information};
  }
  return std::nullopt;
}

}  // namespace plslam
