// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/matching/segment_projection.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

#include <gtest/gtest.h>

namespace plslam {
namespace {

const StereoCamera kProjectionCamera{400.0, 320.0, 240.0, 0.1, 640, 480};

TEST(ClipInFront, KeepsASegmentInFront) {
  const Segment3 segment{{0.0, 0.0, 2.0}, {1.0, 0.0, 3.0}};
  const auto clipped = ClipInFront(segment, 0.1);
  ASSERT_TRUE(clipped);
  EXPECT_EQ(clipped->p, segment.p);
  EXPECT_EQ(clipped->q, segment.q);
}

TEST(ClipInFront, CutsAtTheNearPlane) {
  const auto clipped = ClipInFront({{0.0, 0.0, -1.0}, {2.0, 0.0, 1.0}}, 0.5);
  ASSERT_TRUE(clipped);
  EXPECT_NEAR(clipped->p.z(), 0.5, 1e-12);
  EXPECT_NEAR(clipped->p.x(), 1.5, 1e-12);
}

TEST(ClipInFront, NothingBehindTheCamera) { EXPECT_FALSE(ClipInFront({{0.0, 0.0, -1.0}, {1.0, 0.0, -2.0}}, 0.1)); }

// The slow twin: the first and the last of many points along the segment that are in the image.
std::optional<Segment2> ClipByWalking(const Segment2& segment, double margin_px) {
  constexpr int kSteps = 20000;
  std::optional<Segment2> inside;
  for (int i = 0; i <= kSteps; ++i) {
    const Eigen::Vector2d px = segment.p + i * (1.0 / kSteps) * (segment.q - segment.p);
    if (!kProjectionCamera.InImage(px, -margin_px)) continue;
    if (!inside) inside = Segment2{px, px};
    inside->q = px;
  }
  return inside;
}

TEST(ClipToImage, AgreesWithWalkingAlongTheSegment) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> any(-500.0, 1200.0);
  int cut = 0;
  int gone = 0;
  for (int i = 0; i < 400; ++i) {
    const double margin_px = i % 3 == 0 ? 0.0 : 10.0 * (i % 3 - 1.5);
    Segment2 segment{{any(random), any(random)}, {any(random), any(random)}};
    if (i % 10 == 0) segment.q.x() = segment.p.x();
    if (i % 10 == 5) segment.q.y() = segment.p.y();
    const auto expected = ClipByWalking(segment, margin_px);
    const auto found = ClipToImage(segment, kProjectionCamera, margin_px);
    const double length_px = expected ? expected->Length() : 0.0;
    const double step_px = segment.Length() / 20000.0;
    if (std::abs(length_px - 5.0) < 3.0 * step_px) continue;  // either is right
    ASSERT_EQ(found.has_value(), length_px >= 5.0) << i << " length " << length_px;
    gone += found ? 0 : 1;
    if (!found) continue;
    EXPECT_LT((found->p - expected->p).norm() + (found->q - expected->q).norm(), 3.0 * step_px) << i;
    EXPECT_TRUE(kProjectionCamera.InImage(found->p, -margin_px) && kProjectionCamera.InImage(found->q, -margin_px))
        << i;
    cut += found->p != segment.p || found->q != segment.q ? 1 : 0;
  }
  EXPECT_GT(cut, 100);
  EXPECT_GT(gone, 50);
}

TEST(ClipToImage, EndsInsideStayBitForBit) {
  const Segment2 inside{{0.1, 0.3}, {639.0, 479.0}};
  const auto same = ClipToImage(inside, kProjectionCamera, 0.0);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->p, inside.p);
  EXPECT_EQ(same->q, inside.q);
  EXPECT_FALSE(ClipToImage({{5.0, 5.0}, {8.0, 5.0}}, kProjectionCamera, 0.0)) << "too short to be of use";
}

// Twin: points of the segment in space, projected, those in front and in the image.
TEST(ProjectSegment, AgreesWithProjectingManyPoints) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> any(-2.0, 2.0);
  int crossing = 0;
  for (int i = 0; i < 200; ++i) {
    const Segment3 segment{{any(random), any(random), any(random) + 1.5},
                           {any(random), any(random), any(random) + 1.5}};
    constexpr int kSteps = 20000;
    std::optional<Segment2> expected;
    double step_px = 0.0;
    Eigen::Vector2d before = Eigen::Vector2d::Zero();
    for (int k = 0; k <= kSteps; ++k) {
      const Eigen::Vector3d p_c = segment.p + k * (1.0 / kSteps) * (segment.q - segment.p);
      if (p_c.z() < 0.1 || !kProjectionCamera.InImage(kProjectionCamera.Project(p_c), 0.0)) continue;
      const Eigen::Vector2d px = kProjectionCamera.Project(p_c);
      if (expected) step_px = std::max(step_px, (px - before).norm());
      if (!expected) expected = Segment2{px, px};
      expected->q = before = px;
    }
    const double length_px = expected ? expected->Length() : 0.0;
    if (std::abs(length_px - 5.0) < 1.0) continue;
    const auto found = ProjectSegment(segment, kProjectionCamera, 0.0);
    ASSERT_EQ(found.has_value(), length_px >= 5.0) << i << " length " << length_px;
    if (!found) continue;
    crossing += segment.p.z() < 0.1 || segment.q.z() < 0.1 ? 1 : 0;
    EXPECT_LT((found->p - expected->p).norm() + (found->q - expected->q).norm(), 4.0 * step_px) << i;
  }
  EXPECT_GT(crossing, 5);
}

TEST(VarianceAcross, GrowsOnlyBeyondTheObservedPiece) {
  const Segment2 observed{{100.0, 100.0}, {200.0, 100.0}};
  EXPECT_DOUBLE_EQ(VarianceAcross(observed, {150.0, 103.0}, 0.5), 0.25);
  EXPECT_DOUBLE_EQ(VarianceAcross(observed, {300.0, 103.0}, 0.5), 2.25);
  EXPECT_DOUBLE_EQ(VarianceAcross(observed, {0.0, 103.0}, 0.5), 2.25);
}

TEST(AlongLine, FindsThePointUnderAPixel) {
  const Segment3 segment{{-1.0, -1.0, 4.0}, {1.0, 1.0, 5.0}};
  for (const double s : {-0.3, 0.0, 0.4, 1.0, 1.2}) {
    const Eigen::Vector2d px = kProjectionCamera.Project(segment.p + s * (segment.q - segment.p));
    const auto found = AlongLine(segment, px, kProjectionCamera);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, s, 1e-9);
  }
}

TEST(AlongLine, RefusesALineThroughTheCameraCentre) {
  EXPECT_FALSE(AlongLine({{0.0, 0.0, 1.0}, {0.0, 0.0, 2.0}}, {320.0, 240.0}, kProjectionCamera));
}

}  // namespace
}  // namespace plslam
