// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/map_path.h"

#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <utility>

#include "core/map/map_graph.h"

namespace plslam::test {
namespace {

SE3 RandomStep(std::mt19937_64& generator) {
  std::uniform_real_distribution<double> value(-1.0, 1.0);
  const Eigen::Vector3d t{value(generator), value(generator), value(generator)};
  return {ExpSO3(0.2 * Eigen::Vector3d{value(generator), value(generator), value(generator)}), t};
}

MapKeyframe After(const Map& map, int id, const SE3& T_step) {
  MapKeyframe keyframe;
  keyframe.name.number = id;
  keyframe.id = KeyframeId(keyframe.name.number);
  if (id == 0) return keyframe;
  keyframe.previous_id = keyframe.parent_id = id - 1;
  keyframe.T_prevkf_kf = T_step;
  keyframe.T_w_kf = map.FindKeyframe(id - 1)->T_w_kf * T_step;
  keyframe.relative_covariance = 1e-5 * static_cast<double>(id) * Matrix6d::Identity();
  return keyframe;
}

Map RandomMap(int n, uint64_t seed) {
  std::mt19937_64 generator(seed);
  Map map;
  for (int i = 0; i < n; ++i) {
    MapKeyframe keyframe = After(map, i, RandomStep(generator));
    if (i > 0) keyframe.parent_id = KeyframeId(generator() % static_cast<uint64_t>(i));
    map.Put(keyframe);
  }
  return map;
}

double Length(const Map& map, KeyframeId a, KeyframeId b) {
  const SE3 T = map.FindKeyframe(a)->T_w_kf.Inverse() * map.FindKeyframe(b)->T_w_kf;
  return T.translation().norm() + T.Log().tail<3>().norm();
}

// Floyd and Warshall over the same edges.
std::vector<std::vector<double>> AllLengths(const Map& map) {
  const size_t n = map.keyframes().size();
  std::vector<std::vector<double>> d(n, std::vector<double>(n, std::numeric_limits<double>::infinity()));
  const auto edge = [&](KeyframeId a, KeyframeId b) {
    if (a >= 0 && b >= 0) d[a.value][b.value] = d[b.value][a.value] = Length(map, a, b);
  };
  for (const auto& [id, keyframe] : map.keyframes()) {
    d[id.value][id.value] = 0.0;
    edge(keyframe.previous_id, id);
    edge(keyframe.parent_id, id);
  }
  for (const LoopEdge& loop : map.loops()) edge(loop.old_keyframe_id, loop.keyframe_id);
  for (size_t k = 0; k < n; ++k) {
    for (size_t i = 0; i < n; ++i) {
      for (size_t j = 0; j < n; ++j) d[i][j] = std::min(d[i][j], d[i][k] + d[k][j]);
    }
  }
  return d;
}

TEST(MapPaths, AreTheShortest) {
  Map map = RandomMap(30, 3);
  map.Add({2, 27, SE3(), 1e-4 * Matrix6d::Identity(), 10, 10});
  const auto lengths = AllLengths(map);
  for (const int to : {0, 13, 29}) {
    loop::MapPaths paths(map, to);
    for (int from = 0; from < 30; ++from) {
      const auto path = paths.From(from);
      ASSERT_TRUE(path.has_value());
      EXPECT_NEAR(path->length_m, lengths[from][to], 1e-9) << from << " to " << to;
    }
  }
}

TEST(MapPaths, ChainCovarianceIsComposedStepByStep) {
  std::mt19937_64 generator(5);
  Map map;
  for (int i = 0; i < 12; ++i) map.Put(After(map, i, RandomStep(generator)));
  Matrix6d forwards = Matrix6d::Zero();
  for (int i = 1; i < 12; ++i) {
    const MapKeyframe& keyframe = *map.FindKeyframe(i);
    forwards = ComposeCovariance(forwards, keyframe.T_prevkf_kf, keyframe.relative_covariance);
  }
  EXPECT_LT((loop::MapPaths(map, 11).CovarianceFrom(0) - forwards).norm(), 1e-9 * forwards.norm());
  // The path back is the same motion turned round.
  const SE3 T_0_11 = map.FindKeyframe(0)->T_w_kf.Inverse() * map.FindKeyframe(11)->T_w_kf;
  const Matrix6d backwards = InverseCovariance(T_0_11, forwards);
  EXPECT_LT((loop::MapPaths(map, 0).CovarianceFrom(11) - backwards).norm(), 1e-9 * backwards.norm());
}

// Even if paths with the same ends were requested before.
TEST(MapPaths, CovarianceIsIndependentOfQueryOrder) {
  Map map = RandomMap(30, 3);
  map.Add({2, 27, SE3(), 1e-4 * Matrix6d::Identity(), 10, 10});
  loop::MapPaths paths(map, 13);
  for (const KeyframeId from : {0, 29, 5, 13, 28, 1}) {
    const Matrix6d alone = loop::MapPaths(map, 13).CovarianceFrom(from);
    EXPECT_EQ(alone, paths.CovarianceFrom(from)) << from;
    EXPECT_EQ(alone.isZero(), from == 13);
  }
}

TEST(MapPaths, ReachIsTheFarthestPointOfThePath) {
  Map map;
  for (int i = 0; i < 5; ++i) {
    map.Put(After(map, i, SE3(Eigen::Quaterniond::Identity(), {i < 3 ? 1.0 : -1.0, 0.0, 0.0})));
  }
  // Out two metres and back: 0, 1, 2, 1, 0.
  const auto path = loop::MapPaths(map, 4).From(0);
  ASSERT_TRUE(path.has_value());
  EXPECT_NEAR(path->length_m, 4.0, 1e-12);
  EXPECT_NEAR(path->reach_m, 2.0, 1e-12);
}

TEST(MapPaths, NoPathBetweenUnconnectedParts) {
  Map map = RandomMap(4, 1);
  MapKeyframe stranger;
  stranger.id = 4;
  stranger.name.session = 2;
  map.Put(stranger);
  EXPECT_FALSE(loop::MapPaths(map, 4).From(0).has_value());
  EXPECT_FALSE(loop::MapPaths(map, 0).From(99).has_value());
  EXPECT_FALSE(loop::MapPaths(map, 99).From(0).has_value());
  EXPECT_TRUE(loop::MapPaths(map, 4).CovarianceFrom(0).isZero());
  EXPECT_EQ(loop::MapPaths(map, 4).From(4)->length_m, 0.0);
}

// For example with a forged id.
TEST(MapPaths, IdsFarApartAndMissingOnes) {
  Map map = RandomMap(30, 3);
  for (const KeyframeId id : {0, 7, 8, 20}) map.RemoveKeyframe(id);
  MapKeyframe far = *map.FindKeyframe(29);
  far.id = KeyframeId(int64_t{1} << 61);
  far.previous_id = far.parent_id = 29;
  map.Put(far);
  loop::MapPaths paths(map, far.id);
  for (int id = 0; id < 40; ++id) {
    EXPECT_EQ(paths.From(id).has_value(), map.FindKeyframe(id) != nullptr && id > 0) << id;
  }
  EXPECT_NEAR(paths.From(29)->length_m, 0.0, 1e-12);
  EXPECT_FALSE(paths.From(KeyframeId(far.id.value - 1)).has_value());
}

// A straight line of steps of a metre; odometry of one step is uncertain.
Map ChainWithStep(int id, double sigma_m, double sigma_rad, double length_m = 1.0) {
  Map map;
  for (int i = 0; i < 6; ++i) {
    const double x_m = i == id ? length_m : 1.0;
    MapKeyframe keyframe = After(map, i, SE3(Eigen::Quaterniond::Identity(), {x_m, 0.0, 0.0}));
    if (i == id) keyframe.relative_covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
    if (i == id) keyframe.relative_covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
    map.Put(keyframe);
  }
  return map;
}

void ShareLandmarks(Map& map, KeyframeId a, KeyframeId b, int n) {
  for (int32_t i = 0; i < n; ++i) {
    MapPoint point;
    point.id = i;
    point.observations = {{a, i}, {b, i}};
    map.Put(point);
  }
}

// The tracker was lost there and continued: its uncertainty is ten metres and a radian, or that of its prediction.
TEST(MapPaths, UnknownStepIsNotPartOfAPath) {
  for (const auto& [sigma_m, sigma_rad] : {std::pair(10.0, 1.0), std::pair(1.5, 0.01), std::pair(0.01, 0.4)}) {
    const Map map = ChainWithStep(3, sigma_m, sigma_rad);
    EXPECT_FALSE(loop::MapPaths(map, 5).From(0).has_value()) << sigma_m << " m " << sigma_rad;
    EXPECT_FALSE(loop::MapPaths(map, 0).From(3).has_value());
    EXPECT_TRUE(loop::MapPaths(map, 5).CovarianceFrom(2).isZero());
    EXPECT_TRUE(loop::MapPaths(map, 5).From(3).has_value());
    EXPECT_TRUE(loop::MapPaths(map, 2).From(0).has_value());
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(loop::MapPaths(ChainWithStep(3, nan, 0.01), 5).From(0).has_value());
}

// For example a fast car, or a session of which many keyframes are missing.
TEST(MapPaths, LongerStepMayHaveALargerError) {
  EXPECT_TRUE(loop::MapPaths(ChainWithStep(3, 0.1, 0.03), 5).From(0).has_value());
  EXPECT_TRUE(loop::MapPaths(ChainWithStep(3, 1.0, 0.03, 20.0), 5).From(0).has_value());
}

TEST(MapPaths, SharedLandmarksBridgeAnUnknownStep) {
  for (const KeyframeId parent_id : {2, 1}) {
    Map map = ChainWithStep(3, 10.0, 1.0);
    MapKeyframe keyframe = *map.FindKeyframe(3);
    keyframe.parent_id = parent_id;
    map.Put(keyframe);
    ShareLandmarks(map, parent_id, 3, Map::kParent - 1);
    EXPECT_FALSE(loop::MapPaths(map, 5).From(0).has_value()) << "a false landmark or two";
    ShareLandmarks(map, parent_id, 3, Map::kParent);
    ASSERT_TRUE(loop::MapPaths(map, 5).From(0).has_value());
    EXPECT_NEAR(loop::MapPaths(map, 5).From(0)->length_m, 5.0, 1e-12);
    EXPECT_LT(loop::MapPaths(map, 5).CovarianceFrom(0).norm(), 0.1);
  }
}

}  // namespace
}  // namespace plslam::test
