// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/line_extent.h"

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::FeatureWorld;
using test::HandmadeMap;

// An edge from x = -1 to 1 m at a depth of 4 m; pixels 220 to 420 from the origin. Positions on it are given by x.
Segment3 Part(double from_m, double to_m) { return {{from_m, 0.2, 4.0}, {to_m, 0.2, 4.0}}; }

class LineExtent : public testing::Test {
 protected:
  /// The landmark, and the part of the edge that each keyframe, a little beside the previous one, sees.
  void Put(const Segment3& landmark, const std::vector<Segment3>& seen) {
    std::vector<Observation> observations;
    for (const Segment3& part : seen) {
      const double n = static_cast<double>(observations.size());
      const KeyframeId id =
          m_.AddKeyframe({Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.05 * n, -0.1 * n, 0.0)});
      observations.push_back(m_.SeeLine(id, part, look_));
    }
    m_.PutLine(0, landmark, look_, observations);
  }
  // Ends after `ExtendAndTrim`, x in m; the line must not move.
  std::pair<double, double> Ends() {
    ExtendAndTrim({0, 55}, m_.features, FeatureWorld::Camera(), m_.map);
    EXPECT_EQ(test::WrongWith(m_.map), "");
    const Segment3& segment_w = m_.map.FindLine(0)->segment_w;
    for (const Eigen::Vector3d& end : {segment_w.p, segment_w.q}) {
      EXPECT_LT((end - Eigen::Vector3d(end.x(), 0.2, 4.0)).norm(), 1e-9) << end.transpose();
    }
    return {segment_w.p.x(), segment_w.q.x()};
  }

  const Descriptor look_ = DescriptorOf(9);
  HandmadeMap m_;
};

constexpr double kClose = 1e-6;

TEST_F(LineExtent, LongerIfTwoViewsSeeItLonger) {
  Put(Part(-0.5, 0.5), {Part(-0.5, 0.5), Part(-0.9, 0.7), Part(-0.8, 0.8)});
  const auto [from, to] = Ends();
  EXPECT_NEAR(from, -0.8, kClose);
  EXPECT_NEAR(to, 0.7, kClose);
}

TEST_F(LineExtent, OneViewAloneDoesNotMakeItLonger) {
  Put(Part(-0.5, 0.5), {Part(-0.5, 0.5), Part(-0.5, 0.5), Part(-1.0, 1.0)});
  const auto [from, to] = Ends();
  EXPECT_NEAR(from, -0.5, kClose);
  EXPECT_NEAR(to, 0.5, kClose);
}

TEST_F(LineExtent, ShorterIfAllViewsSeeItShorter) {
  Put(Part(-1.0, 1.0), {Part(-0.5, 0.6), Part(-0.4, 0.5), Part(-0.6, 0.55)});
  const auto [from, to] = Ends();
  EXPECT_NEAR(from, -0.5, kClose);
  EXPECT_NEAR(to, 0.55, kClose);
}

TEST_F(LineExtent, OneWholeViewAgainstOneIsNotEnough) {
  Put(Part(-1.0, 1.0), {Part(-1.0, 1.0), Part(-0.5, 0.5)});
  const auto [from, to] = Ends();
  EXPECT_NEAR(from, -0.5, kClose);
  EXPECT_NEAR(to, 0.5, kClose);
}

TEST_F(LineExtent, CovariancesGrowWithTheLength) {
  Put(Part(-0.5, 0.5), {Part(-0.9, 0.5), Part(-0.9, 0.5)});
  Ends();
  EXPECT_GT(m_.map.FindLine(0)->covariance_p.matrix().trace(),
            1.5 * m_.map.FindLine(0)->covariance_q.matrix().trace());
}

// The image ends at x = 3.19 m for a depth of 4 m; the edge continues.
TEST_F(LineExtent, EndsAtTheBorderOfTheImageDoNotTrim) {
  constexpr double kBorder_m = 3.15;
  Put(Part(1.0, 4.5), {Part(1.0, kBorder_m), Part(1.0, kBorder_m + 0.02)});
  const auto [from, to] = Ends();
  EXPECT_NEAR(from, 1.0, kClose);
  EXPECT_NEAR(to, 4.5, kClose);
}

TEST_F(LineExtent, EndsAtTheBorderExtendIfTwoReachFurther) {
  Put(Part(1.0, 2.5), {Part(1.0, 3.15), Part(1.0, 3.17), Part(1.0, 2.5)});
  EXPECT_NEAR(Ends().second, 3.15, kClose);
}

TEST_F(LineExtent, ViewsAlongTheLineOrWithoutLengthDoNotCount) {
  Put(Part(-0.5, 0.5), {Part(-0.5, 0.5), Part(-0.5, 0.5), Part(-0.2, 0.2)});
  test::ChangeFeatures(m_.features, 2,
                       [](StereoFeatures& of) { of.lines[0].left.segment.q = of.lines[0].left.segment.p; });
  const auto [from, to] = Ends();
  EXPECT_NEAR(from, -0.5, kClose);
  EXPECT_NEAR(to, 0.5, kClose);
}

TEST_F(LineExtent, LineThroughACameraCentre) {
  const Segment3 through{{0.0, 0.0, 2.0}, {0.0, 0.0, 4.0}};
  std::vector<Observation> observations;
  for (const double x : {0.0, 0.0, 0.5}) {
    m_.AddKeyframe({Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0.0, 0.0)});
    observations.push_back(m_.SeeLine(KeyframeId(observations.size()), through, look_));
  }
  test::ChangeFeatures(m_.features, 0, [](StereoFeatures& of) { of.lines[0].left.segment.q.y() += 30.0; });
  m_.PutLine(0, through, look_, observations);
  ExtendAndTrim({0}, m_.features, FeatureWorld::Camera(), m_.map);
  EXPECT_EQ(test::WrongWith(m_.map), "");
}

TEST_F(LineExtent, SegmentWithoutLengthStays) {
  Put(Part(0.5, 0.5), {Part(-0.5, 0.5), Part(-0.5, 0.5)});
  ExtendAndTrim({0}, m_.features, FeatureWorld::Camera(), m_.map);
  EXPECT_EQ(m_.map.FindLine(0)->segment_w.p, Part(0.5, 0.5).p);
  EXPECT_EQ(m_.map.FindLine(0)->segment_w.q, Part(0.5, 0.5).q);
}

}  // namespace
}  // namespace plslam::mapping
