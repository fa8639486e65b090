// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <numbers>
#include <string>

#include "loop_process/loop_verification.h"
#include "tests/unit/loop/ring_world.h"

namespace plslam::test {
namespace {

constexpr double kPaperTurn_rad = 3.0 * std::numbers::pi / 180.0;

loop::LoopOptions WithGates(loop::LoopGates gates) {
  loop::LoopOptions options;
  options.verification.gates = gates;
  return options;
}

/// Returns all verified candidates of a walk along the ring, without applying any loop.
std::vector<loop::LoopEvidence> LookedAt(const Ring& ring, loop::LoopGates gates) {
  Closing closing(PlacesOf(ring.world), WithGates(gates));
  std::vector<loop::LoopEvidence> all;
  for (const Keyframe& keyframe : ring.walk.keyframes) {
    closing.Show(keyframe);
    const loop::LoopSearch& search = closing.closer.last_search();
    all.insert(all.end(), search.evidence.begin(), search.evidence.end());
  }
  return all;
}

TEST(PaperGates, ReturningRingIsClosedFromNearby) {
  const Ring ring;
  const Closing closing = CloseLoops(ring, WithGates(loop::LoopGates::kPaper));
  ASSERT_FALSE(closing.loops.empty());
  for (const LoopClosure& loop : closing.loops) {
    const LoopEdge& edge = loop.edges.front();
    EXPECT_LE(edge.T_old_kf.translation().norm(), 0.5);
    EXPECT_LE(edge.T_old_kf.Log().tail<3>().norm(), kPaperTurn_rad);
  }
}

// A candidate is accepted if and only if it passes the three tests: neither the reverse direction, nor drift, nor
// previous keyframes are checked.
TEST(PaperGates, EqualTheThreeTestsOfThePaper) {
  int accepted = 0;
  int refused = 0;
  for (const loop::LoopEvidence& e : LookedAt(Ring(), loop::LoopGates::kPaper)) {
    if (e.verdict == loop::LoopVerdict::kNotFound) continue;
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(e.place.pose.covariance);
    const bool passes = eigen.eigenvalues().maxCoeff() < 0.01 && e.edge.T_old_kf.translation().norm() <= 0.5 &&
                        e.edge.T_old_kf.Log().tail<3>().norm() <= kPaperTurn_rad &&
                        2 * e.place.inliers > e.place.matches;
    EXPECT_EQ(e.verdict, passes ? loop::LoopVerdict::kAccepted : loop::LoopVerdict::kPaperGates)
        << loop::LoopVerdictName(e.verdict);
    ++(passes ? accepted : refused);
  }
  EXPECT_GT(accepted, 0);
  EXPECT_GT(refused, 0);
}

// A loop seen from farther away is a loop, too.
TEST(PaperGates, RefuseDistantLoopsOfTheDefaultGates) {
  int far = 0;
  for (const loop::LoopEvidence& e : LookedAt(Ring(), loop::LoopGates::kDefault)) {
    if (e.verdict == loop::LoopVerdict::kAccepted && e.edge.T_old_kf.translation().norm() > 0.5) ++far;
  }
  EXPECT_GT(far, 0);
  for (const loop::LoopEvidence& e : LookedAt(Ring(), loop::LoopGates::kPaper)) {
    if (e.edge.T_old_kf.translation().norm() <= 0.5) continue;
    EXPECT_NE(e.verdict, loop::LoopVerdict::kAccepted) << e.edge.T_old_kf.translation().norm() << " m";
  }
}

}  // namespace
}  // namespace plslam::test
