// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/run_paths.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/se3.h"

namespace plslam::evaluate {
namespace {

const SE3 kT_w_other(ExpSO3({0.1, 0.7, -0.2}), {3.0, -1.0, 2.0});

/// A curve in space, its positions in another frame.
Trajectory Curve(const SE3& T_frame_curve, int64_t from_ns = 0) {
  Trajectory curve;
  for (int i = 0; i < 50; ++i) {
    const double s = 0.1 * i;
    const SE3 pose(Eigen::Quaterniond::Identity(), {std::cos(s), std::sin(2.0 * s), 0.3 * s});
    curve.push_back({from_ns + i * int64_t{50'000'000}, T_frame_curve * pose});
  }
  return curve;
}

double Difference(const SE3& a, const SE3& b) { return (a.matrix() - b.matrix()).norm(); }

TEST(RunPaths, JoinedByTheTruthOfBoth) {
  RunPaths base, other;
  base.T_truth_w = SE3(ExpSO3({0.0, 0.3, 0.0}), {1.0, 0.0, 0.0});
  other.T_truth_w = *base.T_truth_w * kT_w_other;
  EXPECT_LT(Difference(BaseFromOther(base, other), kT_w_other), 1e-12);
}

TEST(RunPaths, JoinedByTheirOwnPathsWithoutTruth) {
  RunPaths base, other;
  base.estimate = Curve(SE3());
  other.estimate = Curve(kT_w_other.Inverse());
  EXPECT_LT(Difference(BaseFromOther(base, other), kT_w_other), 1e-6);
  base.T_truth_w = SE3(ExpSO3({0.0, 0.3, 0.0}), {1.0, 0.0, 0.0});
  EXPECT_LT(Difference(BaseFromOther(base, other), kT_w_other), 1e-6) << "the truth of one joins nothing";
}

TEST(RunPaths, NothingInCommonIsOneStart) {
  RunPaths base, other;
  base.estimate = Curve(SE3());
  other.estimate = Curve(kT_w_other, 1'000'000'000'000);
  EXPECT_EQ(Difference(BaseFromOther(base, other), SE3()), 0.0);
}

}  // namespace
}  // namespace plslam::evaluate
