// SPDX-License-Identifier: BSD-3-Clause
// The optimum of our bundle adjustment against that of Ceres with the reference cost functions, on problems of real
// sequences.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iterator>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "loop_process/loop_service.h"
#include "mapping_process/insertion/local_window.h"
#include "tests/support/data_folder.h"
#include "tests/support/loop_run.h"
#include "tests/unit/reference/reference_window.h"

namespace plslam::test {
namespace {

/// Keeps only the inliers of a result; returns whether any observation was none.
bool DropOutliers(const BundleResult& result, BundleProblem& problem) {
  const auto drop = [](auto& observations, const std::vector<bool>& inliers) {
    size_t i = 0;
    return std::erase_if(observations, [&](const auto&) { return !inliers[i++]; });
  };
  const size_t points = drop(problem.point_observations, result.point_inliers);
  return drop(problem.line_observations, result.line_inliers) + points > 0;
}

/// Another start than the recorded one, which is a result of our solver: free poses are moved by a centimetre and a
/// fifth of a degree, landmarks by a hundredth of their distance from the first camera that observes them.
void MoveStart(BundleProblem& problem) {
  std::mt19937 random(1);
  std::normal_distribution<double> gauss;
  const auto vector = [&] { return Eigen::Vector3d(gauss(random), gauss(random), gauss(random)); };
  const auto move = [&](Eigen::Vector3d& p_w, int pose) {
    p_w += 0.01 * (p_w - problem.poses[static_cast<size_t>(pose)].T_w_c.translation()).norm() * vector();
  };
  std::set<int> moved_points, moved_lines;
  for (const PointObservation& seen : problem.point_observations) {
    if (moved_points.insert(seen.point).second) move(problem.points[static_cast<size_t>(seen.point)].p_w, seen.pose);
  }
  for (const LineObservation& seen : problem.line_observations) {
    if (!moved_lines.insert(seen.line).second) continue;
    Segment3& segment_w = problem.lines[static_cast<size_t>(seen.line)].segment_w;
    move(segment_w.p, seen.pose);
    move(segment_w.q, seen.pose);
  }
  for (BundlePose& pose : problem.poses) {
    Vector6d step;
    step << 0.01 * vector(), 0.0035 * vector();
    if (!pose.fixed) pose.T_w_c = pose.T_w_c * SE3::Exp(step);
  }
}

void ExpectTheSameOptimum(BundleProblem problem, const std::string& name) {
  // Only observations that fit, so that both solvers have the same ones throughout.
  DropOutliers(AdjustBundle(problem, {}, nullptr, BundleCovariances::kNone), problem);
  MoveStart(problem);
  BundleOptions options;
  options.max_iterations = 500;
  options.max_refinements = 0;
  options.function_tolerance = 1e-15;
  BundleResult ours;
  // Ours returns landmarks without any inlier to their start (lines whose anchors are far off there).
  do {
    ours = AdjustBundle(problem, options, nullptr, BundleCovariances::kNone);
    ASSERT_TRUE(ours.ok) << name << ": " << ours.reason;
  } while (DropOutliers(ours, problem));
  const double cost_of_ours = ReferenceWindow(problem, false, options.huber_delta).CostAt(ours, false);
  ReferenceWindow reference(problem, false, options.huber_delta);
  const double cost = reference.Solve();
  EXPECT_NEAR(cost_of_ours, cost, 1e-6 * cost) << name;
  double worst = 0.0;
  for (size_t i = 0; i < problem.poses.size(); ++i) {
    worst = std::max(worst, (ours.T_w_c[i].Inverse() * reference.T_w_c(i)).Log().norm());
  }
  EXPECT_LT(worst, 1e-6) << name << ", " << problem.poses.size() << " poses, " << problem.point_observations.size()
                         << " and " << problem.line_observations.size() << " observations of points and lines, cost "
                         << cost;
}

class RecordedWindows : public testing::TestWithParam<const char*> {};

TEST_P(RecordedWindows, EndInTheSameOptimum) {
  PLSLAM_REQUIRE_DATA(folder, GetParam());
  const SlamRun run = RunSlam(*OpenDataset(folder.string(), ""), {}, {});
  const mapping::MappingOptions mapping;
  int n = 0;
  for (const auto& [id, keyframe] : run.map.keyframes()) {
    const MapBundle window =
        mapping::MakeLocalWindow(id, run.map, run.features, mapping::Visits(), run.camera, mapping.window);
    if (window.problem.poses.size() < 5) continue;
    ExpectTheSameOptimum(window.problem, "window of keyframe " + std::to_string(id.value));
    ++n;
  }
  EXPECT_GE(n, 8);
}

INSTANTIATE_TEST_SUITE_P(Sequences, RecordedWindows, testing::Values("euroc_MH_01_a", "kitti_03"),
                         [](const auto& instance) { return std::string(instance.param); });

/// The whole map of the laps or of the flight through a room, which pass most places several times, with its loops as
/// motions.
class RecordedMaps : public testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(RecordedMaps, EndInTheSameOptimum) {
  std::string dataset = GetParam().second;
  if (!dataset.starts_with("synthetic:")) {
    PLSLAM_REQUIRE_DATA(folder, dataset);
    dataset = folder.string();
  }
  const LoopRun run = RunLoops(*OpenDataset(dataset, ""), loop::LoadPlaces({}, {}), {});
  EXPECT_GE(run.revisits.closed, 1);
  const Map& map = run.slam.map;
  std::vector<KeyframeId> keyframes;
  std::vector<LandmarkId> points, lines;
  for (const auto& [id, keyframe] : map.keyframes()) keyframes.push_back(id);
  for (const auto& [id, point] : map.points()) points.push_back(id);
  for (const auto& [id, line] : map.lines()) lines.push_back(id);
  std::vector<bool> fixed(keyframes.size(), false);
  fixed[0] = true;
  MapBundle bundle = MakeMapBundle(map, run.slam.features, run.slam.camera, keyframes, fixed, points, lines, 1.0);
  const auto index = [&](KeyframeId id) {
    return static_cast<int>(std::distance(keyframes.begin(), std::ranges::lower_bound(keyframes, id)));
  };
  for (const LoopEdge& loop : map.loops()) {
    bundle.problem.relative_poses.push_back(
        {index(loop.old_keyframe_id), index(loop.keyframe_id), loop.T_old_kf, loop.covariance});
  }
  ExpectTheSameOptimum(bundle.problem, fmt::format("{} keyframes, {} loops", keyframes.size(), map.loops().size()));
}

INSTANTIATE_TEST_SUITE_P(Rooms, RecordedMaps,
                         testing::Values(std::pair("Laps", "synthetic:room?size=376x240&loops=2&speed=2"),
                                         std::pair("Flight", "euroc_V1_01_sparse")),
                         [](const auto& instance) { return std::string(instance.param.first); });

}  // namespace
}  // namespace plslam::test
