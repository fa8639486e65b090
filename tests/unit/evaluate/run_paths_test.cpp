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

constexpr int64_t kLater_ns = 1'000'000'000'000;

TEST(RunPaths, JoinedByTheTruthOfBoth) {
  const SE3 T_truth_base(ExpSO3({0.0, 0.3, 0.0}), {1.0, 0.0, 0.0});
  plslam::Run base, other;
  base.trajectory = Curve(SE3());
  base.truth = Curve(T_truth_base);
  other.trajectory = Curve(kT_w_other.Inverse(), kLater_ns);
  other.truth = Curve(T_truth_base, kLater_ns);
  EXPECT_LT(Difference(*TruthFromMap(base), T_truth_base), 1e-6);
  EXPECT_LT(Difference(BaseFromOther(base, other), kT_w_other), 1e-6);
}

TEST(RunPaths, JoinedByTheirOwnPathsWithoutTruth) {
  plslam::Run base, other;
  base.trajectory = Curve(SE3());
  other.trajectory = Curve(kT_w_other.Inverse());
  EXPECT_LT(Difference(BaseFromOther(base, other), kT_w_other), 1e-6);
  base.truth = Curve(SE3(ExpSO3({0.0, 0.3, 0.0}), {1.0, 0.0, 0.0}));
  EXPECT_LT(Difference(BaseFromOther(base, other), kT_w_other), 1e-6) << "the truth of one joins nothing";
}

TEST(RunPaths, NothingInCommonIsOneStart) {
  plslam::Run base, other;
  base.trajectory = Curve(SE3());
  other.trajectory = Curve(kT_w_other, kLater_ns);
  EXPECT_EQ(Difference(BaseFromOther(base, other), SE3()), 0.0);
}

}  // namespace
}  // namespace plslam::evaluate
