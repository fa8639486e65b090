// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/accuracy/consistency.h"
#include "tests/unit/evaluate/pairs.h"
#include "tools/evaluate/absolute_error.h"

namespace plslam {
namespace {

const SE3 kMove = SE3::Exp((Vector6d() << 5, -3, 2, 0.5, -1.1, 2.0).finished());

// Truth = scale and kMove applied to the estimate.
PosePairs MovedPairs(const Trajectory& estimate, double scale) {
  const Similarity move{scale, kMove};
  Trajectory truth;
  for (const TrajectoryPose& pose : estimate) truth.push_back({pose.t_ns, move.Apply(pose.T_a_b)});
  return Pair(estimate, truth);
}

double Distance(const SE3& a, const SE3& b) { return (a.Inverse() * b).Log().norm(); }

Trajectory Line(int n) {
  Trajectory line;
  const SE3 start = SE3::Exp((Vector6d() << 7, 1, -2, 0.3, 0.2, -0.7).finished());
  for (int i = 0; i < n; ++i) line.push_back({i, start * Translation(0.3 * i, -0.1 * i, 0.5 * i)});
  return line;
}

TEST(Alignment, RigidMotionIsRecovered) {
  const Similarity s = Align(MovedPairs(SomePath(50), 1.0), Alignment::kSe3);
  EXPECT_EQ(s.scale, 1.0);
  EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
}

TEST(Alignment, SimilarityIsRecovered) {
  const Similarity s = Align(MovedPairs(SomePath(50), 2.5), Alignment::kSim3);
  EXPECT_NEAR(s.scale, 2.5, 1e-12);
  EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
}

TEST(Alignment, AgreesWithEigensUmeyamaOnDriftingPaths) {
  const Trajectory truth = SomePath(80);
  const PosePairs pairs =
      Pair(WithDrift(truth, SE3::Exp((Vector6d() << 0.02, 0, 0.01, 0, 0.004, 0.002).finished())), truth);
  Eigen::Matrix3Xd from(3, pairs.size());
  Eigen::Matrix3Xd to(3, pairs.size());
  for (size_t i = 0; i < pairs.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = pairs[i].estimate.translation();
    to.col(static_cast<Eigen::Index>(i)) = pairs[i].truth.translation();
  }
  for (const bool with_scale : {false, true}) {
    const Similarity ours = Align(pairs, with_scale ? Alignment::kSim3 : Alignment::kSe3);
    Eigen::Matrix4d m = ours.T_a_b.matrix();
    m.topLeftCorner<3, 3>() *= ours.scale;
    const Eigen::Matrix4d theirs = Eigen::umeyama(from, to, with_scale);
    EXPECT_LT((m - theirs).norm(), 1e-9) << "scale " << with_scale << "\n" << m << "\n" << theirs;
  }
}

TEST(Alignment, PlanarPathGetsARotationAndNoReflection) {
  Trajectory plane;
  for (int i = 0; i < 20; ++i) plane.push_back({i, Translation(std::cos(0.3 * i), std::sin(0.3 * i), 0)});
  const Similarity s = Align(MovedPairs(plane, 1.0), Alignment::kSe3);
  EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
}

TEST(Alignment, StraightPathTakesTheTurnAboutItselfFromTheOrientations) {
  for (const int n : {2, 3, 30}) {
    for (const auto kind : {Alignment::kSe3, Alignment::kSim3}) {
      const Similarity s = Align(MovedPairs(Line(n), 1.0), kind);
      EXPECT_NEAR(s.scale, 1.0, 1e-12);
      EXPECT_LT(Distance(s.T_a_b, kMove), 1e-7) << n << " poses";
    }
  }
}

TEST(Alignment, StraightPathsAheadAndBackAreTurnedProperly) {
  Trajectory truth;
  Trajectory estimate;
  for (int i = 0; i < 5; ++i) {
    truth.push_back({i, Translation(i, 0, 0)});
    estimate.push_back({i, Translation(-i, 0, 0)});
  }
  const PosePairs pairs = Pair(estimate, truth);
  const Similarity s = Align(pairs, Alignment::kSe3);
  EXPECT_NEAR(s.T_a_b.R().determinant(), 1.0, 1e-12);
  EXPECT_LT(Summarise(ComputeAbsoluteErrors(pairs, s).translation_m).max, 1e-12);
}

TEST(Alignment, StandingStillIsAlignedByOrientation) {
  const Trajectory still{{0, kMove}, {1, kMove}, {2, kMove}};
  for (const auto kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kFirst}) {
    const Similarity s = Align(MovedPairs(still, 1.0), kind);
    EXPECT_EQ(s.scale, 1.0);
    EXPECT_LT(Distance(s.T_a_b, kMove), 1e-9);
  }
}

TEST(Alignment, NoneAndNothingAreIdentity) {
  EXPECT_EQ(Align({}, Alignment::kSim3).scale, 1.0);
  for (const auto kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kFirst, Alignment::kNone}) {
    EXPECT_LT(Align({}, kind).T_a_b.Log().norm(), 1e-15);
  }
  EXPECT_LT(Align(MovedPairs(SomePath(5), 1.0), Alignment::kNone).T_a_b.Log().norm(), 1e-15);
}

TEST(Alignment, OnePoseIsMadeEqual) {
  for (const auto kind : {Alignment::kSe3, Alignment::kSim3, Alignment::kFirst}) {
    EXPECT_LT(Distance(Align(MovedPairs(SomePath(1), 1.0), kind).T_a_b, kMove), 1e-9);
  }
}

TEST(Alignment, NamesGoBothWays) {
  for (const char* name : {"none", "first", "se3", "sim3"}) EXPECT_EQ(AlignmentName(AlignmentFromName(name)), name);
  EXPECT_THROW(AlignmentFromName("rigid"), std::runtime_error);
}

TEST(AbsoluteError, OffsetAndTurnByHand) {
  const SE3 turned(Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY())), Eigen::Vector3d(3, 4, 0));
  const AbsoluteErrors errors = ComputeAbsoluteErrors({{0, turned, SE3(), 0}}, {});
  EXPECT_DOUBLE_EQ(errors.translation_m.at(0), 5.0);
  EXPECT_NEAR(errors.rotation_rad.at(0), 0.1, 1e-12);
}

TEST(AbsoluteError, AngleIsTheShortOneOfBothQuaternions) {
  const Eigen::Quaterniond q(Eigen::AngleAxisd(3.0, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond minus_q(-q.w(), -q.x(), -q.y(), -q.z());
  EXPECT_NEAR(AngleBetween(q, minus_q), 0.0, 1e-12);
  EXPECT_NEAR(AngleBetween(Eigen::Quaterniond::Identity(), minus_q), 3.0, 1e-12);
}

}  // namespace
}  // namespace plslam
