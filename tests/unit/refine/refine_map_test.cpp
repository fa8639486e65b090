// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/refine_map.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <cmath>
#include <random>
#include <stdexcept>

#include "tests/unit/mapping/mapping_world.h"

namespace plslam::refine {
namespace {

/// A map of a walk through a shell of landmarks, as mapping leaves it, and its true poses.
struct MappedWalk {
  explicit MappedWalk(double noise_px, uint64_t seed = 1, int keyframes = 14, size_t step = 1) {
    const test::FeatureWorld world({500, 80}, seed);
    test::WalkOptions options;
    options.noise_px = noise_px;
    options.seed = seed;
    std::vector<SE3> path;
    const std::vector<SE3> fine = test::TurningPath(keyframes * static_cast<int>(step));
    for (size_t i = 0; i < fine.size(); i += step) path.push_back(fine[i]);
    const test::Walk walk = test::MakeWalk(world, path, options);
    T_w_c = walk.T_w_c;
    for (const Keyframe& keyframe : walk.keyframes) t_ns.push_back(keyframe.t_ns);
    mapping::Mapper mapper = test::MapAll(walk.keyframes);
    stored = mapper.Store();
  }

  StoredMap stored;
  std::vector<SE3> T_w_c;
  std::vector<int64_t> t_ns;
  StereoCamera camera = test::FeatureWorld::Camera();
};

/// Changes all points of a map as a camera with another calibration would have seen them.
template <class Change>
void ChangeFeatures(KeyframeFeatures& features, const Change& change) {
  for (auto& [id, kept] : features) {
    StereoFeatures own = OwnFeatures(kept);
    for (StereoPoint& point : own.points) change(point.left.px, point.disparity_px);
    for (StereoLine& line : own.lines) {
      change(line.left.segment.p, line.disparity_p_px);
      change(line.left.segment.q, line.disparity_q_px);
    }
    kept = KeptFeatures(std::move(own));
  }
}

/// Normalised squared error of the keyframes after the first one, divided by its degrees of freedom.
double MeanNees(const Map& map, const std::vector<SE3>& T_w_c) {
  double sum = 0.0;
  int n = 0;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id == 0) continue;
    const Vector6d e = (keyframe.T_w_kf.Inverse() * T_w_c[static_cast<size_t>(keyframe.name.number)]).Log();
    sum += e.dot(keyframe.covariance.ldlt().solve(e)) / 6.0;
    ++n;
  }
  return sum / n;
}

// Local adjustments see nearly all of so short a walk, so errors hardly change (12 seeds: 1.61 mm before, 1.68 after,
// with 0.06 of chance in the difference), but their covariances are right.
TEST(RefineMap, StatesTheErrorsThatRemain) {
  double before_m = 0.0, after_m = 0.0, nees = 0.0;
  constexpr int kSeeds = 5;
  for (uint64_t seed = 1; seed <= kSeeds; ++seed) {
    MappedWalk walk(0.5, seed);
    before_m += test::PositionError_m(walk.stored.map, walk.T_w_c) / kSeeds;
    const RefineReport report = RefineMap(walk.stored, walk.camera, {});
    after_m += test::PositionError_m(walk.stored.map, walk.T_w_c) / kSeeds;
    ASSERT_TRUE(report.has_covariances) << "seed " << seed;
    nees += MeanNees(walk.stored.map, walk.T_w_c) / kSeeds;
    EXPECT_LE(report.after.normalised, report.before.normalised * 1.01) << "seed " << seed;
    EXPECT_EQ(test::WrongWith(walk.stored.map), "") << "seed " << seed;
    double length_m = 0.0;
    for (const auto& [id, keyframe] : walk.stored.map.keyframes()) {
      const MapKeyframe* previous = walk.stored.map.FindKeyframe(keyframe.previous_id);
      if (previous != nullptr) length_m += (keyframe.T_w_kf.translation() - previous->T_w_kf.translation()).norm();
    }
    EXPECT_NEAR(report.after.length_m, length_m, 1e-9);
    for (const RefineReport::Pass& pass : report.passes) EXPECT_LE(pass.cost_after, pass.cost_before);
  }
  EXPECT_LT(after_m, 1.1 * before_m);
  EXPECT_GT(nees, 0.5);
  EXPECT_LT(nees, 2.0);
}

// Without the noise of features the truth is the optimum, from anywhere near it.
TEST(RefineMap, FindsTheTruthOfExactFeatures) {
  MappedWalk walk(0.0);
  std::map<KeyframeId, SE3> moved;
  for (const auto& [id, keyframe] : walk.stored.map.keyframes()) {
    if (id > 0) moved[id] = keyframe.T_w_kf * SE3::Exp(0.005 * Vector6d::Ones());
  }
  for (const auto& [id, T_w_kf] : moved) walk.stored.map.SetPose(id, T_w_kf, Matrix6d::Zero());
  const double before_m = test::PositionError_m(walk.stored.map, walk.T_w_c);
  RefineMap(walk.stored, walk.camera, {});
  const double after_m = test::PositionError_m(walk.stored.map, walk.T_w_c);
  EXPECT_LT(after_m, 0.1 * before_m) << before_m;
}

TEST(RefineMap, FindsAWrongFocalLength) {
  MappedWalk walk(0.3);
  const Eigen::Vector2d centre(walk.camera.cx_px, walk.camera.cy_px);
  // As a camera of 404 px would have seen it.
  ChangeFeatures(walk.stored.features, [&](Eigen::Vector2d& px, double& disparity_px) {
    px = centre + 1.01 * (px - centre);
    if (disparity_px > 0.0) disparity_px *= 1.01;
  });
  RefineOptions options;
  options.camera = CameraChoice::kIntrinsics;
  const RefineReport report = RefineMap(walk.stored, walk.camera, options);
  ASSERT_EQ(report.pair.state[reference::kFocal], PairState::kEstimated);
  EXPECT_NEAR(report.pair.value[reference::kFocal], 4.0, 3.0 * report.pair.sigma[reference::kFocal]);
  EXPECT_LT(report.pair.sigma[reference::kFocal], 1.5);
  EXPECT_NEAR(walk.camera.f_px, 400.0 + report.pair.value[reference::kFocal], 1e-12);
}

/// Changes all features as a pair with these parameters would have seen them.
void SeeWithPair(const PairParameters& pair, MappedWalk& walk) {
  const StereoCamera& camera = walk.camera;
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise_px(0.0, 0.3);
  for (auto& [id, kept] : walk.stored.features) {
    const MapKeyframe& keyframe = *walk.stored.map.FindKeyframe(id);
    const auto at = static_cast<size_t>(keyframe.name.number);
    const size_t other = at > 0 ? at - 1 : at + 1;
    const double dt_s = 1e-9 * static_cast<double>(walk.t_ns[other] - walk.t_ns[at]);
    const Vector6d twist = (walk.T_w_c[at].Inverse() * walk.T_w_c[other]).Log() / dt_s;
    const auto right_of = [&](const Eigen::Vector2d& px, double disparity_px) {
      const Eigen::Vector3d p_c = camera.Backproject({px.x(), px.y(), disparity_px});
      return reference::PairPixels<double>(camera, pair.data(), twist, p_c).right;
    };
    const auto left_of = [&](const Eigen::Vector2d& px) {
      const Eigen::Vector3d p_c = camera.Backproject({px.x(), px.y(), 1.0});
      return reference::PairPixels<double>(camera, pair.data(), twist, p_c).left;
    };
    StereoFeatures own = OwnFeatures(kept);
    for (StereoPoint& point : own.points) {
      const Eigen::Vector2d ideal_px = point.left.px;
      point.left.px = left_of(ideal_px);
      if (!point.HasDepth()) continue;
      const Eigen::Vector2d right = right_of(ideal_px, point.disparity_px);
      point.disparity_px = point.left.px.x() - right.x();
      point.row_offset_px = static_cast<float>(right.y() - point.left.px.y() + noise_px(random));
      point.sigma_row_px = 0.3F;
    }
    for (StereoLine& line : own.lines) {
      if (line.disparity_p_px <= 0.0 || line.disparity_q_px <= 0.0) continue;
      Segment2& left = line.left.segment;
      const Eigen::Vector2d p = right_of(left.p, line.disparity_p_px), q = right_of(left.q, line.disparity_q_px);
      left = {left_of(left.p), left_of(left.q)};
      // Disparities of lines are measured in the rows of the left ends. Level lines have none.
      if (std::abs(q.y() - p.y()) < 1.0) continue;
      const auto in_row = [&](double y) { return p.x() + (q.x() - p.x()) * (y - p.y()) / (q.y() - p.y()); };
      line.disparity_p_px = left.p.x() - in_row(left.p.y());
      line.disparity_q_px = left.q.x() - in_row(left.q.y());
    }
    kept = KeptFeatures(std::move(own));
  }
}

/// A parameter of the pair and its true value.
class FaultyPair : public testing::TestWithParam<std::pair<reference::PairParameter, double>> {};

TEST_P(FaultyPair, IsFoundWithinThreeSigmas) {
  const auto [parameter, value] = GetParam();
  // The part of the baseline that points forward takes the most views.
  MappedWalk walk(0.3, 1, parameter == reference::kDirectionZ ? 28 : 14, 6);
  PairParameters pair{};
  pair[parameter] = value;
  SeeWithPair(pair, walk);
  RefineOptions options;
  options.camera = parameter == reference::kRadial ? CameraChoice::kIntrinsics : CameraChoice::kAll;
  const RefineReport report = RefineMap(walk.stored, walk.camera, options);
  ASSERT_EQ(report.pair.state[parameter], PairState::kEstimated);
  EXPECT_NEAR(report.pair.value[parameter], value, 3.0 * report.pair.sigma[parameter]);
  EXPECT_LT(report.pair.sigma[parameter], std::abs(value) / 3.0);
  EXPECT_EQ(test::WrongWith(walk.stored.map), "");
}

// Radial distortion of 2 px at 200 px from the centre, rows that differ by 1 px, turns of the right camera, a baseline that points 0.2 degrees aside, and a late right image.
INSTANTIATE_TEST_SUITE_P(RefineMap, FaultyPair,
                         testing::Values(std::pair(reference::kRadial, 0.04), std::pair(reference::kTurnX, 2.5e-3),
                                         std::pair(reference::kTurnY, 1e-3), std::pair(reference::kTurnZ, 3.5e-3),
                                         std::pair(reference::kDirectionY, 3.5e-3),
                                         std::pair(reference::kDirectionZ, 3.5e-3),
                                         std::pair(reference::kTimeSkew, 5e-3)));

TEST(RefineMap, LeavesATrueCameraAsGiven) {
  MappedWalk walk(0.3);
  RefineOptions options;
  options.camera = CameraChoice::kAll;
  const RefineReport report = RefineMap(walk.stored, walk.camera, options);
  for (size_t i = 0; i < reference::kPairSize; ++i) {
    EXPECT_NE(report.pair.state[i], PairState::kEstimated)
        << PairParameterRows()[i].name << " " << report.pair.value[i] << " sigma " << report.pair.sigma[i];
  }
}

TEST(RefineMap, RefusesMapsWithoutFeatures) {
  MappedWalk walk(0.5);
  walk.stored.features.erase(walk.stored.features.begin());
  EXPECT_THROW(RefineMap(walk.stored, walk.camera, {}), std::runtime_error);
  StoredMap none;
  EXPECT_THROW(RefineMap(none, walk.camera, {}), std::runtime_error);
}

TEST(RefineMap, KeepsTheBestOnInterrupt) {
  MappedWalk walk(0.5);
  const std::atomic<bool> stop = true;
  RefineOptions options;
  options.stop = &stop;
  const RefineReport report = RefineMap(walk.stored, walk.camera, options);
  EXPECT_TRUE(report.stopped);
  EXPECT_EQ(report.passes.size(), 1U);
  EXPECT_EQ(test::WrongWith(walk.stored.map), "");
}

TEST(RefineMap, InterruptLeavesTheCameraAsGiven) {
  MappedWalk walk(0.5);
  const StereoCamera camera = walk.camera;
  const SE3 T_w_kf = walk.stored.map.keyframes().rbegin()->second.T_w_kf;
  const std::atomic<bool> stop = true;
  RefineOptions options;
  options.camera = CameraChoice::kAll;
  options.stop = &stop;
  const RefineReport report = RefineMap(walk.stored, walk.camera, options);
  EXPECT_TRUE(report.stopped);
  EXPECT_EQ(walk.camera.f_px, camera.f_px);
  EXPECT_EQ(walk.stored.map.keyframes().rbegin()->second.T_w_kf.translation(), T_w_kf.translation());
  for (const double parameter : report.pair.value) EXPECT_EQ(parameter, 0.0);
}

// Above the limit of memory the pose system is solved by conjugate gradients, with the same result.
TEST(RefineMap, NeedsNoFactorOfThePoses) {
  MappedWalk direct(0.5);
  MappedWalk iterative(0.5);
  RefineOptions options;
  EXPECT_FALSE(RefineMap(direct.stored, direct.camera, options).demand.iterative);
  options.memory_bytes = 1;
  EXPECT_TRUE(RefineMap(iterative.stored, iterative.camera, options).demand.iterative);
  for (const auto& [id, keyframe] : direct.stored.map.keyframes()) {
    const SE3& other = iterative.stored.map.FindKeyframe(id)->T_w_kf;
    EXPECT_LT((keyframe.T_w_kf.Inverse() * other).Log().norm(), 2e-3) << id;
  }
}

}  // namespace
}  // namespace plslam::refine
