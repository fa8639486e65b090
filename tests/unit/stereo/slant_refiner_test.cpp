// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/slant_refiner.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/features/texture.h"
#include "vo_process/stereo/patch_aligner.h"

namespace plslam::vo {
namespace {

constexpr int kSlantedWidth = 300;
constexpr int kSlantedHeight = 140;
constexpr double kRowInformation = 1.0 / (0.3 * 0.3);

/// Disparity over the left image: `at_center` in its middle, growing by the slopes a pixel to the right and down.
struct DisparityPlane {
  double at_center = 0.0;
  double along_row = 0.0;
  double down = 0.0;

  double At(double u, double v) const {
    return at_center + along_row * (u - kSlantedWidth / 2.0) + down * (v - kSlantedHeight / 2.0);
  }
  /// Left column that the right pixel shows.
  double LeftOf(double u_right, double v) const {
    return (u_right + at_center - along_row * kSlantedWidth / 2.0 + down * (v - kSlantedHeight / 2.0)) /
           (1.0 - along_row);
  }
};

cv::Mat RenderRight(const DisparityPlane& plane, const test::View& view, uint64_t seed, double softness) {
  return test::RenderTexture(kSlantedWidth, kSlantedHeight, view, seed, softness,
                             [&plane](double u, double v) { return plane.LeftOf(u, v); });
}

struct SlantErrors {
  int tried = 0;
  std::vector<double> error_px;
  std::vector<double> normalised;

  static double Rms(const std::vector<double>& v) {
    double sum = 0.0;
    for (const double e : v) sum += e * e;
    return std::sqrt(sum / static_cast<double>(v.size()));
  }
  double Rms() const { return Rms(error_px); }
  double Mean() const {
    double sum = 0.0;
    for (const double e : error_px) sum += e;
    return sum / static_cast<double>(error_px.size());
  }
  double Found() const { return static_cast<double>(error_px.size()) / tried; }
};

/// Aligns a grid of patches on the plane, `align` being (position, start) to (disparity, variance).
template <class Align>
SlantErrors AlignAll(const DisparityPlane& plane, const Align& align) {
  SlantErrors errors;
  for (int v = 20; v < kSlantedHeight - 20; v += 6) {
    for (int u = 20; u < kSlantedWidth - 20; u += 7) {
      const Eigen::Vector2d px(u + 0.3, v - 0.4);
      const double truth = plane.At(px.x(), px.y());
      if (px.x() - truth < 20.0 || px.x() - truth > kSlantedWidth - 20.0) continue;
      ++errors.tried;
      const std::optional<std::pair<double, double>> found = align(px, truth);
      if (!found) continue;
      errors.error_px.push_back(found->first - truth);
      errors.normalised.push_back((found->first - truth) / std::sqrt(found->second));
    }
  }
  return errors;
}

struct Pair {
  cv::Mat left;
  cv::Mat right;
  HalvedPair halved;

  Pair(const DisparityPlane& plane, double noise, double softness)
      : left(test::RenderTexture(kSlantedWidth, kSlantedHeight, {.noise = noise, .noise_seed = 1}, 3, softness)),
        right(RenderRight(plane, {.noise = noise, .noise_seed = 2}, 3, softness)),
        halved(left, right) {}
};

SlantErrors WithSlant(const DisparityPlane& plane, const Pair& pair) {
  const HalvedPair::Level& level = pair.halved.LevelFor(1.0);
  return AlignAll(plane, [&](const Eigen::Vector2d& px, double truth) -> std::optional<std::pair<double, double>> {
    const Eigen::Vector2i center(static_cast<int>(std::lround(px.x())), static_cast<int>(std::lround(px.y())));
    const auto found =
        RefineSlanted(level, center, px - center.cast<double>(), {-truth + 0.2, 0.0}, {0.0, kRowInformation});
    if (!found || found->correlation < 0.8) return std::nullopt;
    return std::pair(-found->shift_u_px, found->variance);
  });
}

/// The slow twin without slant: the shift of least squared difference (means removed, no gain), by a search over
/// sixteenths of a pixel.
SlantErrors WithoutSlant(const DisparityPlane& plane, const Pair& pair) {
  return AlignAll(plane, [&](const Eigen::Vector2d& px, double truth) -> std::optional<std::pair<double, double>> {
    const int u = static_cast<int>(std::lround(px.x()));
    const int v = static_cast<int>(std::lround(px.y()));
    const auto difference = [&](double disparity) {
      double sum = 0.0;
      double squares = 0.0;
      for (int y = v - 5; y <= v + 5; ++y) {
        for (int x = u - 5; x <= u + 5; ++x) {
          const double at = x - disparity;
          const int k = static_cast<int>(std::floor(at));
          const double f = at - k;
          const double right = (1.0 - f) * pair.right.at<uint8_t>(y, k) + f * pair.right.at<uint8_t>(y, k + 1);
          const double d = right - pair.left.at<uint8_t>(y, x);
          sum += d;
          squares += d * d;
        }
      }
      return squares - sum * sum / 121.0;
    };
    double best = truth;
    for (int step = -32; step <= 32; ++step) {
      if (difference(truth + step / 16.0) < difference(best)) best = truth + step / 16.0;
    }
    return std::pair(best, 1.0);
  });
}

struct SlantedSurface {
  const char* name;
  DisparityPlane plane;
};

class RefineSlantedOn : public testing::TestWithParam<SlantedSurface> {};

TEST_P(RefineSlantedOn, UnbiasedAndMoreAccurateThanOneShift) {
  const DisparityPlane& plane = GetParam().plane;
  const Pair pair(plane, 0.0, 1.5);
  const SlantErrors with = WithSlant(plane, pair);
  const SlantErrors without = WithoutSlant(plane, pair);
  const std::string figures = "found " + std::to_string(with.Found()) + ", mean " + std::to_string(with.Mean()) +
                              ", rms " + std::to_string(with.Rms()) + ", without slant " +
                              std::to_string(without.Rms());
  EXPECT_GT(with.tried, 100);
  EXPECT_GT(with.Found(), 0.9) << figures;
  EXPECT_LT(std::abs(with.Mean()), 0.01) << figures;
  EXPECT_LT(with.Rms(), 0.06) << figures;
  EXPECT_LT(3.0 * with.Rms(), without.Rms()) << figures;
}

TEST_P(RefineSlantedOn, SlopesAreThoseOfTheSurface) {
  const DisparityPlane& plane = GetParam().plane;
  const Pair pair(plane, 0.0, 1.5);
  const Eigen::Vector2d truth(plane.along_row, plane.down);
  std::vector<double> errors;
  AlignAll(plane, [&](const Eigen::Vector2d& px, double disparity) -> std::optional<std::pair<double, double>> {
    const Eigen::Vector2i center = px.array().round().cast<int>();
    const auto found =
        RefineSlanted(pair.halved.LevelFor(1.0), center, {0.0, 0.0}, {-disparity, 0.0}, {0.0, kRowInformation});
    if (found) errors.push_back((found->disparity_slope - truth).norm());
    return std::nullopt;
  });
  ASSERT_GT(errors.size(), 100U);
  EXPECT_LT(SlantErrors::Rms(errors), 0.06);
}

INSTANTIATE_TEST_SUITE_P(Surfaces, RefineSlantedOn,
                         testing::Values(SlantedSurface{"Road", {40.0, 0.0, 0.3}},
                                         SlantedSurface{"Ceiling", {40.0, 0.0, -0.25}},
                                         SlantedSurface{"WallOnTheLeft", {45.0, -0.2, 0.0}},
                                         SlantedSurface{"WallOnTheRight", {45.0, 0.2, 0.0}},
                                         SlantedSurface{"Both", {40.0, 0.15, 0.2}}),
                         [](const auto& surface) { return surface.param.name; });

TEST(RefineSlanted, SurfacesParallelToTheImagesStayAsGood) {
  for (const double disparity : {20.0, 20.25, 31.8}) {
    const DisparityPlane plane{disparity, 0.0, 0.0};
    const SlantErrors with = WithSlant(plane, Pair(plane, 0.0, 1.0));
    EXPECT_GT(with.Found(), 0.9) << disparity;
    EXPECT_LT(with.Rms(), 0.03) << disparity;
  }
}

TEST(RefineSlanted, MostSlopesBeyondTheLimitAreRefused) {
  const DisparityPlane steep{40.0, 0.0, 0.95};
  const SlantErrors e = WithSlant(steep, Pair(steep, 0.0, 1.5));
  EXPECT_LT(e.Found(), 0.5) << "rms " << e.Rms();
}

TEST(RefineSlanted, NothingOutsideTheImageOrWithoutTexture) {
  const cv::Mat image = test::RandomImage(120, 60, 1);
  const cv::Mat flat(60, 120, CV_8UC1, cv::Scalar(90));
  const HalvedPair pair(image, image);
  const HalvedPair::Level& level = pair.LevelFor(1.0);
  const auto refine = [&](const Eigen::Vector2i& center, double disparity) {
    return RefineSlanted(level, center, {0.0, 0.0}, {-disparity, 0.0}, {0.0, kRowInformation});
  };
  EXPECT_TRUE(refine({60, 30}, 0.0));
  for (const double disparity : {57.0, 60.0, 200.0, -60.0, 1e6})
    EXPECT_FALSE(refine({60, 30}, disparity)) << disparity;
  const HalvedPair half_flat(image, flat);
  EXPECT_FALSE(RefineSlanted(half_flat.LevelFor(1.0), {60, 30}, {0.0, 0.0}, {0.0, 0.0}, {0.0, kRowInformation}));
  const HalvedPair all_flat(flat, flat);
  EXPECT_FALSE(RefineSlanted(all_flat.LevelFor(1.0), {60, 30}, {0.0, 0.0}, {0.0, 0.0}, {0.0, kRowInformation}));
  const HalvedPair left_flat(flat, image);
  EXPECT_FALSE(RefineSlanted(left_flat.LevelFor(1.0), {60, 30}, {0.0, 0.0}, {0.0, 0.0}, {0.0, kRowInformation}));
}

// As the front end calls it: the aligner takes slant into account where the disparity is large.
SlantErrors AlignedByPatchAligner(const DisparityPlane& plane, const Pair& pair) {
  const PatchAligner aligner(pair.halved, 0.3);
  return AlignAll(plane, [&](const Eigen::Vector2d& px, double truth) -> std::optional<std::pair<double, double>> {
    const auto found = aligner.Align(px, 1.0, truth + 0.8);
    if (!found || found->correlation < 0.8) return std::nullopt;
    return std::pair(found->disparity_px, found->sigma_disparity_px * found->sigma_disparity_px);
  });
}

TEST(PatchAlignerOnSlant, NormalisedErrorsAreAboutOne) {
  for (const DisparityPlane& plane :
       {DisparityPlane{40.0, 0.0, 0.3}, DisparityPlane{45.0, 0.2, 0.0}, DisparityPlane{30.0, 0.0, 0.0}}) {
    for (const double noise : {2.0, 5.0}) {
      const SlantErrors e = AlignedByPatchAligner(plane, Pair(plane, noise, 2.0));
      const std::string figures = "noise " + std::to_string(noise) + ", found " + std::to_string(e.Found()) +
                                  ", mean " + std::to_string(e.Mean()) + ", rms " + std::to_string(e.Rms());
      EXPECT_GT(e.Found(), 0.5) << figures;
      EXPECT_GT(SlantErrors::Rms(e.normalised), 0.5) << figures;
      EXPECT_LT(SlantErrors::Rms(e.normalised), 1.4) << figures;
      EXPECT_LT(std::abs(e.Mean()), 0.3 * e.Rms()) << figures;
    }
  }
}

TEST(PatchAlignerOnSlant, CleanRoadsAndWallsAreWithinTheModelError) {
  for (const DisparityPlane& plane : {DisparityPlane{40.0, 0.0, 0.3}, DisparityPlane{45.0, 0.2, 0.0}}) {
    const SlantErrors e = AlignedByPatchAligner(plane, Pair(plane, 0.0, 1.5));
    EXPECT_GT(e.Found(), 0.9);
    EXPECT_LT(std::abs(e.Mean()), 0.01) << e.Mean();
    EXPECT_LT(e.Rms(), 0.06) << e.Rms();
    EXPECT_LT(SlantErrors::Rms(e.normalised), 1.2) << e.Rms();
  }
}

}  // namespace
}  // namespace plslam::vo
