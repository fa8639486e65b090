// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/patch_tracker.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "tests/unit/features/texture.h"
#include "vo_process/stereo/halved_pair.h"

namespace plslam::vo {
namespace {

constexpr int kWidth = 260;
constexpr int kHeight = 160;

struct Followed {
  int tried = 0;
  std::vector<double> error_px;

  double Share() const { return static_cast<double>(error_px.size()) / tried; }
  double Rms() const {
    double squares = 0.0;
    for (const double e : error_px) squares += e * e;
    return error_px.empty() ? 0.0 : std::sqrt(squares / static_cast<double>(error_px.size()));
  }
};

/// Follows a grid of patches from the plain texture into a view of it, expected `wrong_px` beside their positions.
Followed FollowAll(const test::View& view, const Eigen::Vector2d& wrong_px, SearchRange range, double scale = 1.0,
                   double softness = 1.0, int most_levels = 3) {
  const auto then = HalvedImages(test::RenderTexture(kWidth, kHeight, {}, 5, softness));
  const auto now = HalvedImages(test::RenderTexture(kWidth, kHeight, view, 5, softness));
  Followed followed;
  for (int v = 44; v < kHeight - 44; v += 7) {
    for (int u = 44; u < kWidth - 44; u += 9) {
      const Eigen::Vector2d px(u + 0.3, v - 0.2);
      auto patch = StorePatch(then, px, scale);
      if (!patch) continue;
      patch->n_levels = std::min(patch->n_levels, most_levels);
      ++followed.tried;
      const Eigen::Vector2d truth = px - Eigen::Vector2d(view.shift_x_px, view.shift_y_px);
      const auto found = TrackPatch(*patch, now, {truth + wrong_px}, range);
      if (found && found->correlation > 0.8) followed.error_px.push_back((found->px - truth).norm());
    }
  }
  return followed;
}

TEST(PatchTracker, FindsSubPixelShifts) {
  for (const double shift_px : {0.0, 0.25, 0.5, 3.7}) {
    const Followed f = FollowAll({.shift_x_px = shift_px, .shift_y_px = -0.4}, {1.0, -1.0}, SearchRange::kNear);
    EXPECT_GT(f.Share(), 0.5) << shift_px;
    EXPECT_LT(f.Rms(), 0.05) << shift_px;
  }
}

TEST(PatchTracker, CoarseImagesWidenTheRange) {
  const Eigen::Vector2d wrong_px(6.0, -5.0);
  for (const SearchRange range : {SearchRange::kNear, SearchRange::kWide}) {
    const Followed all = FollowAll({.shift_x_px = 2.3}, wrong_px, range, 1.0, 3.0);
    const Followed finest = FollowAll({.shift_x_px = 2.3}, wrong_px, range, 1.0, 3.0, 1);
    EXPECT_GT(all.Share(), 0.35);
    EXPECT_GT(all.Share(), 2.0 * finest.Share());
    EXPECT_LT(all.Rms(), 0.3);
  }
}

TEST(PatchTracker, ExposureMayChange) {
  const Followed f =
      FollowAll({.shift_x_px = 1.4, .gain = 0.5, .offset = 30.0, .noise = 1.0}, {0.5, 0.5}, SearchRange::kNear);
  EXPECT_GT(f.Share(), 0.4);
  EXPECT_LT(f.Rms(), 0.1);
}

TEST(PatchTracker, CoarseFeaturesAreFoundInHalvedImages) {
  const Followed f = FollowAll({.shift_x_px = 2.6, .shift_y_px = 1.2}, {2.0, -2.0}, SearchRange::kNear, 2.0, 3.0);
  EXPECT_GT(f.Share(), 0.4);
  EXPECT_LT(f.Rms(), 0.15);
}

TEST(PatchTracker, TemplatesAreStretchedAsExpected) {
  // Larger, and turned by 20 degrees.
  const Eigen::Matrix2d shape = 1.15 * Eigen::Rotation2Dd(20.0 * M_PI / 180.0).toRotationMatrix();
  const Eigen::Vector2d middle(kWidth / 2.0, kHeight / 2.0);
  const cv::Mat plain = test::RenderTexture(kWidth, kHeight, {}, 5, 2.0);
  cv::Mat enlarged(kHeight, kWidth, CV_8UC1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Eigen::Vector2d at = middle + shape.inverse() * (Eigen::Vector2d(x, y) - middle);
      const int u = std::clamp(static_cast<int>(at.x()), 0, kWidth - 2);
      const int v = std::clamp(static_cast<int>(at.y()), 0, kHeight - 2);
      const double fu = at.x() - u, fv = at.y() - v;
      const auto grey = [&](int c, int r) { return static_cast<double>(plain.at<uint8_t>(r, c)); };
      const double above = grey(u, v) + fu * (grey(u + 1, v) - grey(u, v));
      const double below = grey(u, v + 1) + fu * (grey(u + 1, v + 1) - grey(u, v + 1));
      enlarged.at<uint8_t>(y, x) = static_cast<uint8_t>(std::lround(above + fv * (below - above)));
    }
  }
  const auto then = HalvedImages(plain);
  const auto now = HalvedImages(enlarged);
  Followed with;
  int n_without = 0;
  for (int v = 60; v < kHeight - 60; v += 5) {
    for (int u = 70; u < kWidth - 70; u += 7) {
      const Eigen::Vector2d px(u, v);
      const auto patch = StorePatch(then, px, 1.0);
      if (!patch) continue;
      ++with.tried;
      const Eigen::Vector2d truth = middle + shape * (px - middle);
      const auto found = TrackPatch(*patch, now, {truth, shape}, SearchRange::kNear);
      if (found && found->correlation > 0.95) with.error_px.push_back((found->px - truth).norm());
      const auto unstretched = TrackPatch(*patch, now, {truth}, SearchRange::kNear);
      n_without += unstretched && unstretched->correlation > 0.95 ? 1 : 0;
    }
  }
  EXPECT_GT(with.tried, 50);
  EXPECT_GT(with.Share(), 0.5);
  EXPECT_LT(with.Rms(), 0.1);
  EXPECT_LT(n_without, static_cast<int>(with.error_px.size()) / 2);
}

TEST(PatchTracker, EdgesAndBlankImagesAreNotFollowed) {
  cv::Mat edge(kHeight, kWidth, CV_8UC1, cv::Scalar(60));
  edge.colRange(kWidth / 2, kWidth).setTo(180);
  for (const cv::Mat& image : {edge, cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(90))}) {
    const auto levels = HalvedImages(image);
    const Eigen::Vector2d px(kWidth / 2.0, kHeight / 2.0);
    EXPECT_FALSE(StorePatch(levels, px, 1.0));
  }
}

TEST(PatchTracker, CornersAreNotFollowedIntoBlankImages) {
  const auto patch = StorePatch(HalvedImages(test::RandomImage(kWidth, kHeight, 1)), {80.0, 80.0}, 1.0);
  ASSERT_TRUE(patch);
  const auto blank = HalvedImages(cv::Mat(kHeight, kWidth, CV_8UC1, cv::Scalar(90)));
  for (const SearchRange range : {SearchRange::kNear, SearchRange::kWide})
    EXPECT_FALSE(TrackPatch(*patch, blank, {patch->px}, range));
}

TEST(PatchTracker, BordersAndImpossibleExpectations) {
  const auto levels = HalvedImages(test::RenderTexture(kWidth, kHeight, {}, 5));
  EXPECT_FALSE(StorePatch(levels, {3.0, 80.0}, 1.0));
  EXPECT_FALSE(StorePatch(levels, {80.0, kHeight - 2.0}, 1.0));
  const Eigen::Vector2d px(100.0, 80.0);
  const auto patch = StorePatch(levels, px, 1.0);
  ASSERT_TRUE(patch);
  const double nan = std::nan("");
  EXPECT_FALSE(TrackPatch(*patch, levels, {{nan, 80.0}}, SearchRange::kWide));
  EXPECT_FALSE(TrackPatch(*patch, levels, {{-50.0, 80.0}}, SearchRange::kWide));
  EXPECT_FALSE(TrackPatch(*patch, levels, {px, 9.0 * Eigen::Matrix2d::Identity()}, SearchRange::kWide));
  EXPECT_FALSE(TrackPatch(*patch, levels, {px, Eigen::Matrix2d::Zero()}, SearchRange::kWide));
  EXPECT_FALSE(TrackPatch(*patch, {}, {px}, SearchRange::kWide));
}

}  // namespace
}  // namespace plslam::vo
