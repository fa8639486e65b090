// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/patch_tracker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/LU>

#include "core/geometry/symmetric.h"
#include "vo_process/stereo/patch_aligner.h"

namespace plslam::vo {
namespace {

constexpr int kCoarseIterations = 4;
constexpr int kFineIterations = 8;
constexpr double kCoarseConverged = 0.1;
constexpr double kFineConverged = 0.02;
constexpr double kMaxTravel = 2.5;
constexpr double kMinCoarseCorrelation = 0.7;
/// Ratio of the energy of gradients to that of noise, at least, in every direction.
constexpr double kMinSignal = 4.0;
/// Ratio of the smaller to the larger eigenvalue of the gradients, at least.
constexpr double kMinFirmness = 0.2;
/// Deviation of the derivative from that of a shift below which a template is not warped.
constexpr double kNoWarp = 0.01;
/// Changes of size beyond which a patch shows too little of what it showed.
constexpr double kMinZoom = 0.5;
constexpr double kMaxZoom = 2.0;

/// Patches that show a common shift, at least, and their mean correlation.
constexpr int kLeastShifted = 10;
constexpr int kShiftHalf = 3;
constexpr double kMinCommonCorrelation = 0.5;

constexpr int kRimSide = kSide + 2;  // the patch and one pixel around it

struct Template {
  Patch pixels;
  Patch grad_u;
  Patch grad_v;
  float energy = 0.0F;
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
  double weaker = 0.0;  // smaller eigenvalue of the hessian
};

/// Makes the gradients orthogonal to offset and gain of brightness, and builds the normal equations.
bool Complete(Template& t) {
  RemoveMean(t.pixels);
  RemoveMean(t.grad_u);
  RemoveMean(t.grad_v);
  t.energy = Dot(t.pixels, t.pixels);
  if (!(t.energy > kPixels * kMinNoise * kMinNoise)) return false;
  t.grad_u -= t.pixels * (Dot(t.grad_u, t.pixels) / t.energy);
  t.grad_v -= t.pixels * (Dot(t.grad_v, t.pixels) / t.energy);
  const double uv = Dot(t.grad_u, t.grad_v);
  t.hessian << Dot(t.grad_u, t.grad_u), uv, uv, Dot(t.grad_v, t.grad_v);
  const double half_trace = 0.5 * t.hessian.trace();
  const double half_difference = 0.5 * (t.hessian(0, 0) - t.hessian(1, 1));
  t.weaker = half_trace - std::sqrt(half_difference * half_difference + uv * uv);
  if (!(t.weaker > kMinFirmness * (t.hessian.trace() - t.weaker))) return false;
  return t.weaker > 0.25 * kMinNoise * kMinNoise * kPixels * kMinSignal;
}

/// Template around `center`, which must be `kPatchMargin` from the border.
std::optional<Template> MakeTemplate(const cv::Mat& image, const Eigen::Vector2i& center) {
  const PatchGradients read = ReadGradients(image, center);
  Template t{read.pixels, read.grad_u, read.grad_v};
  if (!Complete(t)) return std::nullopt;
  return t;
}

/// The same with the pixels of the present image, which `then_from_now` takes to the earlier one.
std::optional<Template> MakeWarpedTemplate(const cv::Mat& image, const Eigen::Vector2i& center,
                                           const Eigen::Matrix2d& then_from_now) {
  constexpr int kRimHalf = kHalf + 1;
  const double reach = kRimHalf * std::max(then_from_now.row(0).lpNorm<1>(), then_from_now.row(1).lpNorm<1>()) + 1.0;
  if (!IsInside(image, center.x(), center.y(), reach)) return std::nullopt;
  std::array<float, static_cast<size_t>(kRimSide) * kRimSide> rim;
  const auto step_u = static_cast<float>(then_from_now(0, 0));
  const auto step_v = static_cast<float>(then_from_now(1, 0));
  const size_t stride = image.step;
  for (int y = 0; y < kRimSide; ++y) {
    const Eigen::Vector2d begin = center.cast<double>() + then_from_now * Eigen::Vector2d(-kRimHalf, y - kRimHalf);
    const auto u0 = static_cast<float>(begin.x());
    const auto v0 = static_cast<float>(begin.y());
    for (int x = 0; x < kRimSide; ++x) {
      const float u = u0 + step_u * static_cast<float>(x);
      const float v = v0 + step_v * static_cast<float>(x);
      const int iu = static_cast<int>(u);
      const int iv = static_cast<int>(v);
      const float fu = u - static_cast<float>(iu);
      const float fv = v - static_cast<float>(iv);
      const uint8_t* p = image.data + static_cast<size_t>(iv) * stride + iu;
      const auto a = static_cast<float>(p[0]);
      const auto c = static_cast<float>(p[stride]);
      const float top = a + fu * (static_cast<float>(p[1]) - a);
      const float bottom = c + fu * (static_cast<float>(p[stride + 1]) - c);
      rim[static_cast<size_t>(y) * kRimSide + x] = top + fv * (bottom - top);
    }
  }
  Template t;
  t.pixels.setZero();
  t.grad_u.setZero();
  t.grad_v.setZero();
  for (int y = 0; y < kSide; ++y) {
    const float* row = rim.data() + static_cast<size_t>(y + 1) * kRimSide + 1;
    for (int x = 0; x < kSide; ++x) {
      t.pixels(x, y) = row[x];
      t.grad_u(x, y) = 0.5F * (row[x + 1] - row[x - 1]);
      t.grad_v(x, y) = 0.5F * (row[x + kRimSide] - row[x - kRimSide]);
    }
  }
  if (!Complete(t)) return std::nullopt;
  return t;
}

struct Found {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double noise = 0.0;
  double gain = 0.0;
  double correlation = 0.0;
  bool converged = false;
};

Found Search(const Template& t, const cv::Mat& image, const Eigen::Vector2d& start, int iterations,
             double converged) {
  const Eigen::Matrix2d inverse = t.hessian.inverse();
  Found found;
  found.center = start;
  Patch now;
  for (int iteration = 0; iteration < iterations; ++iteration) {
    if (!IsInside(image, found.center.x(), found.center.y())) return found;
    SamplePatch(image, found.center.x(), found.center.y(), now);
    const float sum = now.sum();
    const double energy = Dot(now, now) - static_cast<double>(sum) * sum / kPixels;
    const double cross = Dot(t.pixels, now);
    if (!(energy > 0.0) || !(cross > 0.0)) return found;
    found.gain = cross / t.energy;
    const Eigen::Vector2d gradient(Dot(t.grad_u, now), Dot(t.grad_v, now));
    const Eigen::Vector2d step = inverse * gradient / found.gain;
    found.center -= step;
    if (!((found.center - start).cwiseAbs().maxCoeff() <= kMaxTravel)) return found;
    if (step.cwiseAbs().maxCoeff() > converged) continue;
    found.correlation = cross / std::sqrt(t.energy * energy);
    const double residual = energy / (found.gain * found.gain) - t.energy;
    found.noise = std::max(std::sqrt(std::max(residual, 0.0) / (kPixels - 4)), kMinNoise);
    found.converged = true;
    return found;
  }
  return found;
}

/// View of stored pixels as an image.
cv::Mat AsImage(std::span<const uint8_t> pixels, int reach) {
  // OpenCV has no image of constant pixels; nothing writes to this one.
  return {2 * reach + 1, 2 * reach + 1, CV_8UC1, const_cast<uint8_t*>(pixels.data())};
}

/// The pixels around a patch at a level; empty if it has none there.
cv::Mat PixelsAt(const StoredPatch& patch, int level) {
  const int i = level - patch.finest_level;
  if (i < 0 || i >= patch.n_levels) return {};
  return i == 0 ? AsImage(patch.finest, StoredPatch::kFinestReach)
                : AsImage(patch.coarse[static_cast<size_t>(i - 1)], StoredPatch::kCoarseReach);
}

/// Copies the pixels around one of an image, repeating those at its border.
void CopyAround(const cv::Mat& image, const Eigen::Vector2i& center, int reach, uint8_t* out) {
  for (int y = -reach; y <= reach; ++y) {
    const uint8_t* row = image.ptr<uint8_t>(std::clamp(center.y() + y, 0, image.rows - 1));
    for (int x = -reach; x <= reach; ++x) *out++ = row[std::clamp(center.x() + x, 0, image.cols - 1)];
  }
}

Eigen::Vector2i Rounded(const Eigen::Vector2d& px) {
  return {static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y()))};
}

Eigen::Vector2i CenterOf(const cv::Mat& image) { return {image.cols / 2, image.rows / 2}; }

/// Searches one level. Returns the position in pixels of that level's image.
std::optional<Found> SearchLevel(const Template& t, const cv::Mat& now, const Eigen::Vector2d& start,
                                 bool is_finest) {
  const Found found = Search(t, now, start, is_finest ? kFineIterations : kCoarseIterations,
                             is_finest ? kFineConverged : kCoarseConverged);
  const double from_noise = 0.25 * found.noise * found.noise * kPixels;
  if (!found.converged || !(t.weaker > kMinSignal * from_noise)) return std::nullopt;
  return found;
}

/// Normalised correlation of two squares of `2 * kShiftHalf + 1` pixels, exact up to the last division.
double Correlation(const cv::Mat& a, const Eigen::Vector2i& at_a, const cv::Mat& b, const Eigen::Vector2i& at_b) {
  int32_t sum_a = 0, sum_b = 0, aa = 0, bb = 0, ab = 0;
  for (int y = -kShiftHalf; y <= kShiftHalf; ++y) {
    const uint8_t* row_a = a.ptr<uint8_t>(at_a.y() + y) + at_a.x() - kShiftHalf;
    const uint8_t* row_b = b.ptr<uint8_t>(at_b.y() + y) + at_b.x() - kShiftHalf;
    for (int x = 0; x <= 2 * kShiftHalf; ++x) {
      const int32_t pa = row_a[x], pb = row_b[x];
      sum_a += pa;
      sum_b += pb;
      aa += pa * pa;
      bb += pb * pb;
      ab += pa * pb;
    }
  }
  const double n = (2 * kShiftHalf + 1) * (2 * kShiftHalf + 1), mean_a = sum_a / n, mean_b = sum_b / n;
  const double energy_a = aa - sum_a * mean_a, energy_b = bb - sum_b * mean_b;
  const double least = n * kMinNoise * kMinNoise;
  return energy_a > least && energy_b > least ? (ab - sum_a * mean_b) / std::sqrt(energy_a * energy_b) : 0.0;
}

}  // namespace

std::optional<StoredPatch> StorePatch(const std::vector<cv::Mat>& levels, const Eigen::Vector2d& px, double scale) {
  StoredPatch patch;
  patch.px = px;
  const int n_levels = std::min(static_cast<int>(levels.size()), StoredPatch::kLevels);
  double size_px = 1.0;
  for (; patch.finest_level + 1 < n_levels && scale > size_px * std::numbers::sqrt2; size_px *= 2.0)
    ++patch.finest_level;
  for (int level = patch.finest_level; level < n_levels; ++level, size_px *= 2.0, ++patch.n_levels) {
    const cv::Mat& image = levels[static_cast<size_t>(level)];
    const Eigen::Vector2i center = Rounded(px / size_px);
    if (!IsInside(image, center.x(), center.y())) break;
    if (patch.n_levels == 0) {
      CopyAround(image, center, StoredPatch::kFinestReach, patch.finest.data());
    } else {
      CopyAround(image, center, StoredPatch::kCoarseReach,
                 patch.coarse[static_cast<size_t>(patch.n_levels - 1)].data());
    }
  }
  if (patch.n_levels == 0) return std::nullopt;
  const cv::Mat finest = AsImage(patch.finest, StoredPatch::kFinestReach);
  if (!MakeTemplate(finest, CenterOf(finest))) return std::nullopt;
  return patch;
}

std::optional<TrackedPatch> TrackPatch(const StoredPatch& patch, const std::vector<cv::Mat>& now,
                                       const PatchExpectation& expected, SearchRange range) {
  if (!expected.px.allFinite() || !expected.now_from_then.allFinite()) return std::nullopt;
  const double determinant = expected.now_from_then.determinant();
  if (!(determinant >= kMinZoom * kMinZoom && determinant <= kMaxZoom * kMaxZoom)) return std::nullopt;
  const Eigen::Matrix2d then_from_now = expected.now_from_then.inverse();
  const bool warps = (then_from_now - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff() > kNoWarp;
  const auto level_of = [&](int i) { return static_cast<size_t>(patch.finest_level + i); };
  const auto search = [&](int i, const Template& t, const Eigen::Vector2d& start_px) -> std::optional<TrackedPatch> {
    const double size_px = static_cast<double>(size_t{1} << level_of(i));
    const Eigen::Vector2d then = patch.px / size_px;
    const Eigen::Vector2d off_center = expected.now_from_then * (then - Rounded(then).cast<double>());
    const auto found = SearchLevel(t, now[level_of(i)], start_px / size_px - off_center, i == 0);
    if (!found) return std::nullopt;
    return TrackedPatch{(found->center + off_center) * size_px, found->correlation, found->gain};
  };
  if (level_of(0) >= now.size()) return std::nullopt;
  const cv::Mat finest = PixelsAt(patch, patch.finest_level);
  const Eigen::Vector2i center = CenterOf(finest);
  const auto exact = warps ? MakeWarpedTemplate(finest, center, then_from_now) : MakeTemplate(finest, center);
  if (!exact) return std::nullopt;
  if (range == SearchRange::kNear) {
    auto found = search(0, *exact, expected.px);
    if (found) return found;
  }
  Eigen::Vector2d start_px = expected.px;
  for (int i = patch.n_levels - 1; i > 0; --i) {
    if (level_of(i) >= now.size()) continue;
    const cv::Mat stored = PixelsAt(patch, patch.finest_level + i);
    const auto coarse = MakeTemplate(stored, CenterOf(stored));
    if (!coarse) continue;
    const auto found = search(i, *coarse, start_px);
    if (found && found->correlation > kMinCoarseCorrelation) start_px = found->px;
  }
  if (range == SearchRange::kNear && start_px == expected.px) return std::nullopt;
  return search(0, *exact, start_px);
}

std::optional<Eigen::Vector2d> CommonShift(std::span<const ExpectedPatch> patches, const std::vector<cv::Mat>& now) {
  constexpr int kLevel = StoredPatch::kLevels - 1;
  constexpr int kShifts = 2 * kMostShift + 1;
  if (static_cast<int>(now.size()) <= kLevel) return std::nullopt;
  const cv::Mat& image = now[kLevel];
  constexpr double kSize_px = 1 << kLevel;
  std::vector<double> sums(static_cast<size_t>(kShifts) * kShifts, 0.0);
  int n = 0;
  for (const ExpectedPatch& expected : patches) {
    const cv::Mat stored = PixelsAt(*expected.patch, kLevel);
    if (stored.empty()) continue;
    const Eigen::Vector2d then = expected.patch->px / kSize_px;
    const Eigen::Vector2i at = Rounded(expected.px / kSize_px - (then - Rounded(then).cast<double>()));
    if (!IsInside(image, at.x(), at.y(), kMostShift + kShiftHalf + 1)) continue;
    ++n;
    double* sum = sums.data();
    for (int y = -kMostShift; y <= kMostShift; ++y) {
      for (int x = -kMostShift; x <= kMostShift; ++x) {
        *sum++ += Correlation(stored, CenterOf(stored), image, at + Eigen::Vector2i(x, y));
      }
    }
  }
  if (n < kLeastShifted) return std::nullopt;
  const auto best = std::max_element(sums.begin(), sums.end());
  if (*best < kMinCommonCorrelation * n) return std::nullopt;
  const auto index = static_cast<int>(best - sums.begin());
  return kSize_px * Eigen::Vector2d(index % kShifts - kMostShift, index / kShifts - kMostShift);
}

}  // namespace plslam::vo
