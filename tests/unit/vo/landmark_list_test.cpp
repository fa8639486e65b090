// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/LU>

#include "vo_process/tracking/landmarks/landmark_list.h"

namespace plslam::vo {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

TEST(IdIndex, ValuesOfAnIdKeepTheirInsertionOrder) {
  const IdIndex<TrackId, std::string> index({{7, "a"}, {3, "b"}, {7, "c"}, {-1, "d"}, {7, "b"}});
  EXPECT_THAT(index.Find(7), ElementsAre(Pair(7, "a"), Pair(7, "c"), Pair(7, "b")));
  EXPECT_THAT(index.Find(3), ElementsAre(Pair(3, "b")));
  EXPECT_THAT(index.Find(-1), ElementsAre(Pair(-1, "d")));
}

TEST(IdIndex, HasNothingForOtherIds) {
  EXPECT_THAT((IdIndex<TrackId, int>({}).Find(0)), IsEmpty());
  EXPECT_THAT((IdIndex<TrackId, int>({{1, 1}, {3, 3}}).Find(2)), IsEmpty());
}

}  // namespace

namespace {

const Eigen::Matrix3d kPrior = Eigen::Vector3d(0.04, 0.09, 0.25).asDiagonal();

std::array<LinearMeasurement, 3> Measurements() {
  return {{{Eigen::RowVector3d(1.0, 0.2, -0.1), 0.3, 0.01},
           {Eigen::RowVector3d(-0.3, 1.1, 0.4), -0.2, 0.02},
           {Eigen::RowVector3d(0.5, 0.1, 0.9), 0.1, 0.05}}};
}

// The same in information form, all rows at once.
void FuseAtOnce(std::span<const LinearMeasurement> measurements, Eigen::Vector3d& x, Eigen::Matrix3d& P) {
  Eigen::Matrix3d information = P.inverse();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const LinearMeasurement& m : measurements) {
    information += m.J.transpose() * m.J / m.variance;
    right += m.J.transpose() * m.residual / m.variance;
  }
  P = information.inverse();
  x += P * right;
}

TEST(FuseMeasurements, SequentialFusionEqualsBatchFusion) {
  const auto measurements = Measurements();
  Eigen::Vector3d x(1.0, 2.0, 3.0);
  Eigen::Vector3d x_twin = x;
  Eigen::Matrix3d P = kPrior;
  Eigen::Matrix3d P_twin = kPrior;
  ASSERT_TRUE(FuseMeasurements(measurements, x, P));
  FuseAtOnce(measurements, x_twin, P_twin);
  EXPECT_LT((x - x_twin).norm(), 1e-12);
  EXPECT_LT((P - P_twin).norm(), 1e-12);
}

TEST(FuseMeasurements, NanLeavesTheLandmarkUnchanged) {
  auto measurements = Measurements();
  measurements[1].residual = std::numeric_limits<double>::quiet_NaN();
  Eigen::Vector3d x(1.0, 2.0, 3.0);
  Eigen::Matrix3d P = kPrior;
  EXPECT_FALSE(FuseMeasurements(measurements, x, P));
  EXPECT_EQ(x, Eigen::Vector3d(1.0, 2.0, 3.0));
  EXPECT_EQ(P, kPrior);
}

}  // namespace
}  // namespace plslam::vo
