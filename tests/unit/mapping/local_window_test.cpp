// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/local_window.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <vector>

#include "mapping_process/mapper.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;

/// A map of fourteen keyframes with the same features, and a second session that continues among them.
class Window : public testing::Test {
 protected:
  void SetUp() override {
    options_.keyframes = 5;
    options_.fixed_keyframes = 6;
    MappingOptions options;
    options.culling.redundant_share = 1.01;  // every keyframe stays
    Mapper mapper(FeatureWorld::Camera(), options);
    for (const Keyframe& keyframe : test::MakeWalk(world_, path_, {}).keyframes) Insert(keyframe, mapper);
    test::WalkOptions walk;
    walk.session = 8;
    walk.seed = 2;
    walk.with_ids = false;
    for (const Keyframe& keyframe : test::MakeWalk(world_, path_, walk).keyframes) Insert(keyframe, mapper);
    MapperState state = mapper.State();
    stored_ = std::move(state.stored);
    visits_ = std::move(state.visits);
  }

  static void Insert(const Keyframe& keyframe, Mapper& mapper) {
    std::string reason;
    ASSERT_TRUE(test::MapOne(keyframe, mapper, &reason)) << reason;
  }

  /// Keyframes that take part around one of the second session, free or constant.
  size_t Around(int64_t session_keyframe_id) const {
    for (const auto& [id, keyframe] : stored_.map.keyframes()) {
      if (keyframe.name.session != 8 || keyframe.name.number != session_keyframe_id) continue;
      return MakeLocalWindow(id, stored_.map, stored_.features, visits_, FeatureWorld::Camera(), options_)
          .keyframes.size();
    }
    return 0;
  }

  /// Free and fixed; twice as many are still fewer than there are.
  static constexpr size_t kUsual = 11;
  WindowOptions options_;
  FeatureWorld world_{{120, 40}, 7};
  std::vector<SE3> path_ = test::TurningPath(14);
  StoredMap stored_;
  Visits visits_;
};

TEST_F(Window, TwiceAsWideAtTheStartOfASession) {
  EXPECT_EQ(Around(0), 2 * kUsual);
  EXPECT_EQ(Around(9), 2 * kUsual);
}

TEST_F(Window, KeyframesOfEarlierVisitsAreConstant) {
  const KeyframeId newest = stored_.map.keyframes().rbegin()->first;
  const MapBundle window =
      MakeLocalWindow(newest, stored_.map, stored_.features, visits_, FeatureWorld::Camera(), options_);
  const auto is_earlier = [&](size_t i) { return stored_.map.FindKeyframe(window.keyframes[i])->name.session != 8; };
  size_t neighbours = 0;  // of the newest, which would be free otherwise
  for (size_t i = 0; i < window.keyframes.size(); ++i) {
    if (!is_earlier(i)) continue;
    EXPECT_TRUE(window.problem.poses[i].fixed) << i;
    if (i < static_cast<size_t>(options_.keyframes)) ++neighbours;
  }
  EXPECT_GT(neighbours, 0U);
  EXPECT_FALSE(window.problem.poses.front().fixed);
}

TEST_F(Window, FewerPointsIfEachIsSeenOften) {
  const KeyframeId newest = stored_.map.keyframes().rbegin()->first;
  const auto make = [&] {
    return MakeLocalWindow(newest, stored_.map, stored_.features, visits_, FeatureWorld::Camera(), options_);
  };
  const MapBundle all = make();
  ASSERT_GT(all.problem.point_observations.size(), 100U);
  options_.max_point_observations = static_cast<int>(all.problem.point_observations.size() / 2);
  const MapBundle half = make();
  EXPECT_LE(half.problem.point_observations.size(), all.problem.point_observations.size() / 2);
  EXPECT_GE(half.problem.point_observations.size(), all.problem.point_observations.size() / 3);
  EXPECT_LT(half.points.size(), all.points.size() / 2) << "of those that most keyframes see";
  EXPECT_EQ(half.lines, all.lines);
}

// Its poses had not converged, so that outliers could not be distinguished from observations that would have agreed.
TEST_F(Window, StoppedAdjustmentKeepsAllObservations) {
  const KeyframeId newest = stored_.map.keyframes().rbegin()->first;
  MapBundle window =
      MakeLocalWindow(newest, stored_.map, stored_.features, visits_, FeatureWorld::Camera(), options_);
  for (BundlePose& pose : window.problem.poses) {
    if (!pose.fixed) pose.T_w_c = pose.T_w_c * SE3(Eigen::Quaterniond::Identity(), {0.3, 0.0, 0.0});
  }
  for (const bool stopped : {true, false}) {
    const std::atomic<bool> stop{stopped};
    BundleOptions bundle;
    bundle.max_refinements = stopped ? 1 : 0;
    bundle.max_iterations = 1;
    const BundleResult result = AdjustBundle(window.problem, bundle, &stop);
    ASSERT_TRUE(result.ok) << result.reason;
    ASSERT_EQ(result.stopped, stopped);
    ASSERT_EQ(result.converged, !stopped);
    Map map = stored_.map;
    const AdjustmentFigures figures = ApplyAdjustment(window, result, stored_.features, map);
    if (stopped) {
      EXPECT_EQ(figures.n_outliers, 0);
    } else {
      EXPECT_GT(figures.n_outliers, 0) << "one step is not enough for them all";
    }
  }
}

// The adjustment gives it a standard deviation of a kilometre.
TEST_F(Window, KeyframeWithoutObservationsKeepsCovariance) {
  const KeyframeId newest = stored_.map.keyframes().rbegin()->first;
  MapBundle window =
      MakeLocalWindow(newest, stored_.map, stored_.features, visits_, FeatureWorld::Camera(), options_);
  ASSERT_EQ(window.keyframes.front(), newest);
  ASSERT_FALSE(window.problem.relative_poses.empty());
  std::erase_if(window.problem.point_observations,
                [](const PointObservation& observation) { return observation.pose == 0; });
  std::erase_if(window.problem.line_observations,
                [](const LineObservation& observation) { return observation.pose == 0; });
  BundleResult result = AdjustBundle(window.problem, {}, nullptr);
  ASSERT_TRUE(result.ok) << result.reason;
  ASSERT_GT(result.pose_covariances[0].trace(), 1e6);
  // As many as the map's own observations, over which `ApplyAdjustment` iterates.
  const MapBundle whole =
      MakeLocalWindow(newest, stored_.map, stored_.features, visits_, FeatureWorld::Camera(), options_);
  result.point_inliers.assign(whole.problem.point_observations.size(), true);
  result.line_inliers.assign(whole.problem.line_observations.size(), true);
  Map map = stored_.map;
  ApplyAdjustment(window, result, stored_.features, map);
  EXPECT_EQ(map.FindKeyframe(newest)->covariance, stored_.map.FindKeyframe(newest)->covariance);
  for (size_t i = 1; i < window.keyframes.size(); ++i) {
    if (window.problem.poses[i].fixed) continue;
    EXPECT_NE(map.FindKeyframe(window.keyframes[i])->covariance,
              stored_.map.FindKeyframe(window.keyframes[i])->covariance);
  }
}

TEST_F(Window, NormalWidthLaterInASession) {
  EXPECT_EQ(Around(10), kUsual);
  EXPECT_EQ(Around(13), kUsual);
}

}  // namespace
}  // namespace plslam::mapping
