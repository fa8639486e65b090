// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/point_batch.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/motion/normal_equations.h"
#include "tests/unit/motion/motion_world.h"
#include "tests/unit/motion/slow_point_residual.h"

namespace plslam {
namespace {

constexpr double kDelta = 1.3;
constexpr double kHiddenCost = 77.0;

struct Sum {
  NormalEquations equations;
  std::array<int, 5> count_by_dimension{};
};

Sum AddBatch(const std::vector<PreparedPoint>& points, const std::vector<char>& active, const PoseView& view) {
  Sum sum;
  PointBatch(points).AddTo(active, view, kDelta, kHiddenCost, sum.equations, sum.count_by_dimension);
  return sum;
}

Sum AddOneByOne(const std::vector<PreparedPoint>& points, const std::vector<char>& active, const PoseView& view) {
  Sum sum;
  NormalEquations& e = sum.equations;
  for (size_t i = 0; i < points.size(); ++i) {
    if (active[i] == 0) continue;
    Residual<3> residual;
    if (!test::Linearize(points[i], view, 0.0, residual) || !Whiten(residual)) {
      e.cost += kHiddenCost;
      continue;
    }
    const double squared = residual.r.squaredNorm();
    const double weight = PseudoHuberWeight(squared, kDelta);
    e.H_data += weight * residual.J.transpose() * residual.J;
    e.g += weight * residual.J.transpose() * residual.r;
    e.cost += PseudoHuberLoss(squared, kDelta);
    e.squares += squared;
    e.weighted_squares += weight * squared;
    ++sum.count_by_dimension[residual.dimension];
  }
  return sum;
}

void ExpectEqual(const Sum& sum, const Sum& expected) {
  const NormalEquations& a = sum.equations;
  const NormalEquations& b = expected.equations;
  const Matrix6d lower = b.H_data.triangularView<Eigen::Lower>();
  EXPECT_LE((a.H_data - lower).norm(), 1e-11 * lower.norm()) << a.H_data << "\nexpected\n" << lower;
  EXPECT_LE((a.g - b.g).norm(), 1e-11 * b.g.norm()) << a.g.transpose() << " expected " << b.g.transpose();
  EXPECT_NEAR(a.cost, b.cost, 1e-11 * b.cost);
  EXPECT_NEAR(a.squares, b.squares, 1e-11 * b.squares);
  EXPECT_NEAR(a.weighted_squares, b.weighted_squares, 1e-11 * b.weighted_squares);
  EXPECT_EQ(sum.count_by_dimension, expected.count_by_dimension);
}

// Returns points, some without a disparity, some behind the camera.
std::vector<PreparedPoint> MixedPoints(const test::MotionWorld& world) {
  std::vector<PreparedPoint> points;
  for (size_t i = 0; i < world.points.size(); ++i) {
    PointCorrespondence o = world.points[i];
    if (i % 3 == 1) o.uvd.z() = -1.0;
    if (i % 7 == 2) o.p_ref.z() = -o.p_ref.z();
    points.push_back(*Prepare(o, MotionOptions()));
  }
  return points;
}

TEST(PointBatch, SumsEqualThoseOfSinglePoints) {
  test::MotionWorldMaker maker(11);
  for (int n = 0; n <= 25; ++n) {
    const test::MotionWorld world = maker.Make(n, 0, {1.0, 0.7, 0.5});
    const std::vector<PreparedPoint> points = MixedPoints(world);
    std::vector<char> active(points.size());
    for (char& flag : active) flag = maker.Uniform(0.0, 1.0) < 0.8 ? 1 : 0;
    const PoseView view(world.T_cur_ref * maker.SmallMotion(0.05, 0.02), world.camera);
    SCOPED_TRACE(n);
    ExpectEqual(AddBatch(points, active, view), AddOneByOne(points, active, view));
  }
}

TEST(PointBatch, SquaredNormsEqualThoseOfSinglePoints) {
  test::MotionWorldMaker maker(12);
  const test::MotionWorld world = maker.Make(30, 0, {1.0, 0.7, 0.5});
  const std::vector<PreparedPoint> points = MixedPoints(world);
  const PoseView view(world.T_cur_ref, world.camera);
  for (const double floor_px : {0.0, 2.0}) {
    const std::vector<double> norms = PointBatch(points).SquaredNorms(view, floor_px);
    ASSERT_EQ(norms.size(), points.size());
    for (size_t i = 0; i < points.size(); ++i) {
      Residual<3> residual;
      const bool seen = test::Linearize(points[i], view, floor_px, residual) && Whiten(residual);
      const double expected = seen ? residual.r.squaredNorm() : std::numeric_limits<double>::infinity();
      if (seen) {
        EXPECT_NEAR(norms[i], expected, 1e-11 * expected) << "point " << i;
      } else {
        EXPECT_EQ(norms[i], expected) << "point " << i;
      }
    }
  }
}

TEST(PointBatch, OverflowCostsAsMuchAsAHiddenPoint) {
  test::MotionWorldMaker maker(13);
  const test::MotionWorld world = maker.Make(6, 0, {1.0, 0.7, 0.5});
  std::vector<PreparedPoint> points;
  for (const PointCorrespondence& o : world.points) points.push_back(*Prepare(o, MotionOptions()));
  points[2].uvd.x() = 1e200;
  points[3].covariance.setConstant(-1e9);
  points[4].covariance.setConstant(1e308);
  const PoseView view(world.T_cur_ref, world.camera);
  const Sum sum = AddBatch(points, std::vector<char>(6, 1), view);
  const Sum others = AddBatch(points, {1, 1, 0, 0, 0, 1}, view);
  EXPECT_TRUE(sum.equations.H_data.allFinite()) << sum.equations.H_data;
  EXPECT_NEAR((sum.equations.H_data - others.equations.H_data).norm(), 0.0, 1e-9 * others.equations.H_data.norm());
  EXPECT_NEAR(sum.equations.cost, others.equations.cost + 3 * kHiddenCost, 1e-9);
  EXPECT_EQ(sum.count_by_dimension[3], 3);
}

}  // namespace
}  // namespace plslam
