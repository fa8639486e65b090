#include "core/features/segment_projection.h"

#include <gtest/gtest.h>

namespace plslam {
namespace {

const StereoCamera kCamera{400.0, 320.0, 240.0, 0.1, 640, 480};

TEST(ClipInFront, KeepsWhatIsInFront) {
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

TEST(VarianceAcross, GrowsOnlyBeyondTheObservedPiece) {
  const Segment2 observed{{100.0, 100.0}, {200.0, 100.0}};
  EXPECT_DOUBLE_EQ(VarianceAcross(observed, {150.0, 103.0}, 0.5), 0.25);
  EXPECT_DOUBLE_EQ(VarianceAcross(observed, {300.0, 103.0}, 0.5), 2.25);
  EXPECT_DOUBLE_EQ(VarianceAcross(observed, {0.0, 103.0}, 0.5), 2.25);
}

TEST(AlongLine, FindsThePlaceUnderAPixel) {
  const Segment3 segment{{-1.0, -1.0, 4.0}, {1.0, 1.0, 5.0}};
  for (const double s : {-0.3, 0.0, 0.4, 1.0, 1.2}) {
    const Eigen::Vector2d px = kCamera.Project(segment.p + s * (segment.q - segment.p));
    const auto found = AlongLine(segment, px, kCamera);
    ASSERT_TRUE(found);
    EXPECT_NEAR(*found, s, 1e-9);
  }
}

TEST(AlongLine, RefusesALineThroughTheCameraCentre) {
  EXPECT_FALSE(AlongLine({{0.0, 0.0, 1.0}, {0.0, 0.0, 2.0}}, {320.0, 240.0}, kCamera));
}

}  // namespace
}  // namespace plslam
