// SPDX-License-Identifier: BSD-3-Clause
#include "core/features/lines/line_select.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace plslam {
namespace {

DetectedSegment Piece(double px, double py, double qx, double qy, double contrast = 30.0) {
  return {{{px, py}, {qx, qy}}, contrast};
}

TEST(MergeCollinear, JoinsPiecesOfOneEdge) {
  const auto merged = MergeCollinear({Piece(10, 10, 50, 10.2), Piece(55, 10.1, 100, 10.3), Piece(104, 10, 130, 10)});
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_NEAR(merged[0].segment.Length(), 120.0, 0.2);
  EXPECT_GT(merged[0].segment.q.x(), merged[0].segment.p.x());
}

TEST(MergeCollinear, WeighsPiecesByTheirLength) {
  // A straight 100 px piece and a short one 0.8 px beside it: the result stays near the long one.
  const auto merged = MergeCollinear({Piece(0, 20, 100, 20), Piece(104, 20.8, 116, 20.8)});
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_NEAR(merged[0].segment.p.y(), 20.0, 0.2);
  EXPECT_NEAR(merged[0].segment.q.y(), 20.5, 0.35);
}

TEST(MergeCollinear, LeavesOtherPolaritySlantGapAndOffsetApart) {
  EXPECT_EQ(MergeCollinear({Piece(10, 10, 50, 10), Piece(100, 10, 55, 10)}).size(), 2U) << "polarity";
  EXPECT_EQ(MergeCollinear({Piece(10, 10, 50, 10), Piece(54, 10, 90, 17)}).size(), 2U) << "slant";
  EXPECT_EQ(MergeCollinear({Piece(10, 10, 50, 10), Piece(75, 10, 115, 10)}).size(), 2U) << "gap";
  EXPECT_EQ(MergeCollinear({Piece(10, 10, 50, 10), Piece(54, 13, 90, 13)}).size(), 2U) << "offset";
  EXPECT_EQ(MergeCollinear({Piece(10, 10, 50, 10), Piece(10, 13, 50, 13)}).size(), 2U) << "parallel";
}

TEST(MergeCollinear, DropsDuplicates) {
  const auto merged = MergeCollinear({Piece(10, 10, 90, 10), Piece(20, 10.6, 70, 10.5)});
  ASSERT_EQ(merged.size(), 1U);
  EXPECT_EQ(merged[0].segment.Length(), 80.0);
}

TEST(MergeCollinear, EveryDirectionAlike) {
  for (int k = 0; k < 128; ++k) {
    const Eigen::Vector2d d(std::cos(k * M_PI / 64), std::sin(k * M_PI / 64));
    const Eigen::Vector2d o(200, 200);
    const auto merged = MergeCollinear({{{o, o + 40 * d}, 20}, {{o + 45 * d, o + 80 * d}, 20}});
    ASSERT_EQ(merged.size(), 1U) << k;
    EXPECT_NEAR((merged[0].segment.q - o - 80 * d).norm(), 0.0, 1e-9) << k;
  }
}

TEST(MergeCollinear, OrderOfTheInputDoesNotMatter) {
  std::vector<DetectedSegment> pieces;
  for (int i = 0; i < 60; ++i) {
    const double x = 10.0 * ((i * 37) % 60);
    pieces.push_back(Piece(x, 5.0 * (i % 7), x + 8.0 + i % 5, 5.0 * (i % 7) + 0.1 * (i % 3)));
  }
  const auto forward = MergeCollinear(pieces);
  std::reverse(pieces.begin(), pieces.end());
  const auto backward = MergeCollinear(pieces);
  ASSERT_EQ(forward.size(), backward.size());
  for (size_t i = 0; i < forward.size(); ++i) EXPECT_EQ(forward[i].segment.p, backward[i].segment.p) << i;
}

TEST(MergeCollinear, NothingOneAndDegenerate) {
  EXPECT_TRUE(MergeCollinear({}).empty());
  EXPECT_EQ(MergeCollinear({Piece(1, 1, 30, 30)}).size(), 1U);
  EXPECT_TRUE(MergeCollinear({Piece(5, 5, 5, 5)}).empty());
}

TEST(SelectSpread, CrowdedCellLeavesRoomForOthers) {
  std::vector<DetectedSegment> segments;
  for (int i = 0; i < 100; ++i) segments.push_back(Piece(10, 10 + 0.1 * i, 70, 10 + 0.1 * i));
  segments.push_back(Piece(500, 400, 530, 400));
  const auto kept = SelectSpread(segments, {640, 480}, 40);
  ASSERT_EQ(kept.size(), 40U);
  bool has_far = false;
  for (const DetectedSegment& s : kept) has_far |= s.segment.p.x() > 400;
  EXPECT_TRUE(has_far);
}

TEST(SelectSpread, KeepsAllWhereThereIsRoom) {
  const std::vector<DetectedSegment> two = {Piece(0, 0, 50, 0), Piece(0, 9, 40, 9)};
  EXPECT_EQ(SelectSpread(two, {100, 100}, 2).size(), 2U);
  EXPECT_EQ(SelectSpread(two, {100, 100}, 1).size(), 1U);
  EXPECT_TRUE(SelectSpread({}, {100, 100}, 5).empty());
}

}  // namespace
}  // namespace plslam
