// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/global_bundle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/unit/loop/ring_world.h"

namespace plslam::test {
namespace {

// Returns a map in which each keyframe except the first has its own perturbation.
Map Perturbed(const Map& map) {
  Map perturbed = map;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id == map.keyframes().begin()->first) continue;
    Vector6d x;
    const auto s = static_cast<double>(id.value);
    x << 0.02 * std::sin(s), 0.02 * std::cos(2.0 * s), 0.02 * std::sin(3.0 * s), 0.003 * std::cos(s),
        0.003 * std::sin(5.0 * s), 0.003 * std::cos(3.0 * s);
    perturbed.SetPose(id, keyframe.T_w_kf * SE3::Exp(x), keyframe.covariance);
  }
  return perturbed;
}

double Error_m(const LoopClosure& adjusted, const std::vector<SE3>& T_w_c, const Map& map) {
  double sum = 0.0;
  for (const CorrectedPose& pose : adjusted.poses) {
    const auto number = static_cast<size_t>(map.FindKeyframe(pose.keyframe_id)->name.number);
    sum += (pose.T_w_kf.translation() - T_w_c.at(number).translation()).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(adjusted.poses.size()));
}

TEST(AdjustGlobally, PerturbedKeyframesAreRecovered) {
  const Ring ring(25);
  const mapping::Mapper mapper = MapAll(ring.walk.keyframes);
  KeyframeFeatures features;
  for (const auto& [id, keyframe] : mapper.map().keyframes()) {
    features[id] = ring.walk.keyframes.at(static_cast<size_t>(keyframe.name.number)).features;
  }
  const Map perturbed = Perturbed(mapper.map());
  loop::GlobalBundleProblem problem = loop::MakeGlobalBundleProblem(perturbed, features, FeatureWorld::Camera(), {});
  problem.keyframe.session = 7;
  problem.keyframe.number = 24;
  ASSERT_EQ(problem.keyframes.size(), mapper.map().keyframes().size());
  EXPECT_TRUE(problem.bundle.poses.front().fixed);
  const LoopClosure adjusted = loop::AdjustGlobally(problem, {}, nullptr);
  EXPECT_EQ(adjusted.kind, LoopClosure::Kind::kAdjustment);
  EXPECT_EQ(adjusted.keyframe.number, 24);
  ASSERT_EQ(adjusted.poses.size(), problem.keyframes.size());
  const double before_m = PositionError_m(perturbed, ring.walk.T_w_c);
  const double after_m = Error_m(adjusted, ring.walk.T_w_c, perturbed);
  EXPECT_GT(before_m, 0.02);
  EXPECT_LT(after_m, 0.3 * before_m);
  EXPECT_EQ(adjusted.poses.front().T_w_kf.matrix(), perturbed.keyframes().begin()->second.T_w_kf.matrix());
}

// Two adjustments that loops have ended one after the other, and the one that follows.
TEST(AdjustmentProgress, ContinuesAfterEarlierAdjustments) {
  const Ring ring(25);
  const mapping::Mapper mapper = MapAll(ring.walk.keyframes);
  KeyframeFeatures features;
  for (const auto& [id, keyframe] : mapper.map().keyframes()) {
    features[id] = ring.walk.keyframes.at(static_cast<size_t>(keyframe.name.number)).features;
  }
  const auto make = [&](SourceId source) {
    loop::GlobalBundleProblem problem =
        loop::MakeGlobalBundleProblem(Perturbed(mapper.map()), features, FeatureWorld::Camera(), {});
    problem.map_version = {{}, source, 1};
    return problem;
  };
  loop::AdjustmentProgress progress;
  loop::GlobalBundleOptions one_step;
  one_step.bundle.max_iterations = 1;
  std::vector<CorrectedPose> reached;
  for (int i = 0; i < 2; ++i) {
    loop::GlobalBundleProblem problem = make(5);
    progress.Apply(problem);
    reached = loop::AdjustGlobally(problem, one_step, nullptr).poses;
    progress.Add(problem, reached);
  }
  loop::GlobalBundleProblem next = make(5);
  const loop::GlobalBundleProblem as_given = next;
  progress.Apply(next);
  ASSERT_EQ(reached.size(), next.keyframes.size());
  for (size_t i = 0; i < reached.size(); ++i) {
    EXPECT_LT((next.bundle.poses[i].T_w_c.Inverse() * reached[i].T_w_kf).Log().norm(), 1e-9) << i;
  }
  const auto last_point = static_cast<int>(next.bundle.points.size()) - 1;
  const PointObservation& first =
      *std::find_if(next.bundle.point_observations.begin(), next.bundle.point_observations.end(),
                    [last_point](const PointObservation& seen) { return seen.point == last_point; });
  const auto place = [&first](const loop::GlobalBundleProblem& problem) {
    const SE3& T_w_c = problem.bundle.poses[static_cast<size_t>(first.pose)].T_w_c;
    return Eigen::Vector3d(T_w_c.Inverse() * problem.bundle.points[static_cast<size_t>(first.point)].p_w);
  };
  EXPECT_LT((place(next) - place(as_given)).norm(), 1e-9) << "goes with the first one that sees it";
  EXPECT_GT((next.bundle.points[static_cast<size_t>(first.point)].p_w -
             as_given.bundle.points[static_cast<size_t>(first.point)].p_w)
                .norm(),
            1e-6);
  loop::GlobalBundleProblem of_another = make(6);
  progress.Apply(of_another);
  EXPECT_EQ(of_another.bundle.poses[3].T_w_c.matrix(), as_given.bundle.poses[3].T_w_c.matrix());
}

TEST(MakeGlobalBundleProblem, LandmarkAndObservationLimits) {
  const Ring ring(20);
  const mapping::Mapper mapper = MapAll(ring.walk.keyframes);
  KeyframeFeatures features;
  for (const auto& [id, keyframe] : mapper.map().keyframes()) {
    features[id] = ring.walk.keyframes.at(static_cast<size_t>(keyframe.name.number)).features;
  }
  loop::GlobalBundleOptions options;
  options.points_per_keyframe = 15;
  const loop::GlobalBundleProblem problem =
      loop::MakeGlobalBundleProblem(mapper.map(), features, FeatureWorld::Camera(), options);
  std::map<int, int> observations_of_point;
  for (const PointObservation& observation : problem.bundle.point_observations)
    ++observations_of_point[observation.point];
  ASSERT_EQ(observations_of_point.size(), problem.bundle.points.size());
  for (const auto& [point, observations] : observations_of_point) EXPECT_GE(observations, options.min_observations);
  EXPECT_LE(problem.bundle.points.size(), 15U * problem.keyframes.size());
  EXPECT_GE(problem.bundle.points.size(), 30U);
}

TEST(AdjustGlobally, StoppedAtOnceChangesNothing) {
  const Ring ring(8);
  const mapping::Mapper mapper = MapAll(ring.walk.keyframes);
  KeyframeFeatures features;
  for (const auto& [id, keyframe] : mapper.map().keyframes()) {
    features[id] = ring.walk.keyframes.at(static_cast<size_t>(keyframe.name.number)).features;
  }
  const std::atomic<bool> stop = true;
  const LoopClosure adjusted = loop::AdjustGlobally(
      loop::MakeGlobalBundleProblem(mapper.map(), features, FeatureWorld::Camera(), {}), {}, &stop);
  for (const CorrectedPose& pose : adjusted.poses) {
    EXPECT_LT((pose.T_w_kf.Inverse() * mapper.map().FindKeyframe(pose.keyframe_id)->T_w_kf).Log().norm(), 1e-9);
  }
}

TEST(AdjustGlobally, EmptyMap) {
  const loop::GlobalBundleProblem problem = loop::MakeGlobalBundleProblem(Map(), {}, FeatureWorld::Camera(), {});
  EXPECT_TRUE(loop::AdjustGlobally(problem, {}, nullptr).poses.empty());
}

}  // namespace
}  // namespace plslam::test
