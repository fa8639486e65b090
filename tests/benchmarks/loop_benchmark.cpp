// SPDX-License-Identifier: BSD-3-Clause
// CPU time of loop_process for a keyframe, by the size of the map, and of closing a loop. The maps are synthetic:
// keyframes along a circle, landmarks observed by five consecutive keyframes, random descriptors, all words of the
// vocabulary equally likely.
//
//   loop_benchmark --benchmark_min_time=0.5

#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include "loop_process/loop_closer.h"
#include "loop_process/loop_correction.h"
#include "loop_process/loop_service.h"
#include "tests/support/feature_world.h"

namespace plslam::test {
namespace {

constexpr int kPoints = 300;
constexpr int kLines = 60;
constexpr int kSeenBy = 5;
constexpr double kStep_m = 0.2;

Descriptor DescriptorOf(uint64_t seed) {
  std::mt19937_64 generator(seed);
  return {generator(), generator(), generator(), generator()};
}

SE3 OnCircle(int i, int n) {
  const double a = 2.0 * std::numbers::pi * i / n;
  const double radius_m = kStep_m * n / (2.0 * std::numbers::pi);
  return {ExpSO3({0.0, a, 0.0}), {radius_m * (1.0 - std::cos(a)), 0.0, radius_m * std::sin(a)}};
}

/// A map of `n` keyframes around a circle and their features. If it `closes`, the last keyframe sees the features of
/// the first ones, as its own landmarks.
struct MadeUpMap {
  explicit MadeUpMap(int n, bool closes = false) : seen_in_map(closes ? n - 1 : n) {
    for (int i = 0; i < n; ++i) AddKeyframe(i, n);
    for (int i = 0; i < n; ++i) AddLandmarks(i, n);
    if (closes) SeeBeginning(n - 1);
  }

  void AddKeyframe(int i, int n) {
    MapKeyframe entry;
    entry.name.number = i;
    entry.id = KeyframeId(entry.name.number);
    entry.name.session = 1;
    entry.T_w_kf = entry.T_odom_kf = OnCircle(i, n);
    if (i > 0) {
      entry.previous_id = entry.parent_id = i - 1;
      entry.T_prevkf_kf = OnCircle(i - 1, n).Inverse() * entry.T_w_kf;
      entry.relative_covariance = 1e-5 * Matrix6d::Identity();
    }
    map.Put(entry);
    Keyframe keyframe;
    keyframe.name.session = 1;
    keyframe.name.number = i;
    keyframes.push_back(keyframe);
  }

  // A fifth of a keyframe's landmarks are new; they are in front of it and of the next ones.
  void AddLandmarks(int i, int n) {
    std::mt19937_64 generator(static_cast<uint64_t>(i) + 1);
    std::uniform_real_distribution<double> across(-1.0, 1.0);
    for (int k = 0; k < kPoints / kSeenBy; ++k) {
      MapPoint point;
      point.id = LandmarkId(next_point++);
      point.p_w =
          OnCircle(i, n) * Eigen::Vector3d{3.5 * across(generator), 2.0 * across(generator), 6.0 + across(generator)};
      point.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      point.descriptor = DescriptorOf(generator());
      for (int j = i; j < std::min(seen_in_map, i + kSeenBy); ++j) {
        point.observations.push_back(
            {j, static_cast<int32_t>(keyframes[static_cast<size_t>(j)].features.points.size())});
        point.depth_m = See(j, point);
      }
      if (point.observations.empty()) continue;
      map.Put(point);
    }
    for (int k = 0; k < kLines / kSeenBy; ++k) {
      StereoLine line;
      line.left.segment = {{100.0, 100.0 + k}, {200.0, 200.0 + k}};
      for (int j = i; j < std::min(n, i + kSeenBy); ++j) {
        line.left.descriptor = DescriptorOf(generator());
        keyframes[static_cast<size_t>(j)].features.lines.push_back(line);
      }
    }
  }

  // The last keyframe has its own landmarks: the duplicates are not yet known.
  void SeeBeginning(int j) {
    std::vector<MapPoint> seen;
    for (const auto& [id, point] : map.points()) {
      if (point.observations.front().keyframe_id() < kSeenBy) seen.push_back(point);
    }
    for (MapPoint& point : seen) {
      point.id = LandmarkId(next_point++);
      point.observations = {{j, static_cast<int32_t>(keyframes[static_cast<size_t>(j)].features.points.size())}};
      point.depth_m = See(j, point);
      map.Put(point);
    }
  }

  /// Depth in metres.
  double See(int j, const MapPoint& point) {
    const Eigen::Vector3d p_c = map.FindKeyframe(j)->T_w_kf.Inverse() * point.p_w;
    StereoPoint seen;
    const Eigen::Vector3d uvd = FeatureWorld::Camera().ProjectStereo(p_c);
    seen.left.px = uvd.head<2>();
    seen.disparity_px = uvd.z();
    seen.left.descriptor = point.descriptor;
    keyframes[static_cast<size_t>(j)].features.points.push_back(seen);
    return p_c.z();
  }

  int seen_in_map;
  Map map;
  std::vector<Keyframe> keyframes;
  int64_t next_point = 0;
};

// No loop is confirmed by so many keyframes, so that the correction of the map is not in the time.
loop::LoopOptions Unconfirmed() {
  loop::LoopOptions options;
  options.verification.consistent_keyframes = 10;
  return options;
}

/// Loop closer that has been shown all but the last keyframe of a map, and the map.
struct Shown {
  Shown(int n, bool closes)
      : world(n, closes), closer(FeatureWorld::Camera(), loop::LoadPlaces({}, {}), Unconfirmed()) {
    for (const Keyframe& keyframe : world.keyframes) closer.AddKeyframe(keyframe);
    closer.Follow(world.map);
    last = world.keyframes.back();
    world.keyframes.clear();
  }

  MadeUpMap world;
  loop::LoopCloser closer;
  Keyframe last;
};

Shown& ShownOf(int n, bool closes) {
  static std::unique_ptr<Shown> shown;
  static std::pair<int, bool> which;
  if (shown && which == std::pair(n, closes)) return *shown;
  shown.reset();
  shown = std::make_unique<Shown>(n, closes);
  which = {n, closes};
  return *shown;
}

// Either there is no similar keyframe, or the circle closes, and the loop is verified from both sides.
void BM_Check(benchmark::State& state, bool closes) {
  Shown& shown = ShownOf(static_cast<int>(state.range(0)), closes);
  for (auto _ : state) {
    // The keyframe is added again each time, so that it is described each time.
    shown.closer.AddKeyframe(shown.last);
    benchmark::DoNotOptimize(shown.closer.Check(shown.world.map, shown.last.name));
  }
  const loop::LoopSearch& search = shown.closer.last_search();
  state.counters["looked_at"] = static_cast<double>(search.evidence.size());
  if (!search.evidence.empty()) state.SetLabel(loop::LoopVerdictName(search.evidence.front().verdict));
}
BENCHMARK_CAPTURE(BM_Check, new_place, false)->RangeMultiplier(10)->Range(100, 10000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Check, seen_again, true)->RangeMultiplier(10)->Range(100, 10000)->Unit(benchmark::kMillisecond);

void BM_CloseLoop(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  MadeUpMap world(n);
  // Drift: each step has the same small error, which adds up to the same total over one round of any map.
  Vector6d error;
  error << 1e-1, 5e-2, -1e-1, 1e-2, 2e-2, -1e-2;
  error /= n;
  SE3 T_w_kf = OnCircle(0, n);
  for (int i = 1; i < n; ++i) {
    T_w_kf = T_w_kf * OnCircle(i - 1, n).Inverse() * OnCircle(i, n) * SE3::Exp(error);
    world.map.SetPose(i, T_w_kf, Matrix6d::Identity());
  }
  LoopEdge loop;
  loop.old_keyframe_id = 0;
  loop.keyframe_id = n - 1;
  loop.T_old_kf = OnCircle(0, n).Inverse() * OnCircle(n - 1, n);
  loop.covariance = 1e-4 * Matrix6d::Identity();
  bool closed = false;
  for (auto _ : state) closed = loop::CloseLoop(world.map, loop, {}).has_value();
  if (!closed) state.SkipWithError("the pose graph rejects the loop: this is not the time of closing one");
}
BENCHMARK(BM_CloseLoop)->Arg(100)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plslam::test

BENCHMARK_MAIN();
