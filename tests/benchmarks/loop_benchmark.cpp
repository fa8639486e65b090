// Time of what loop_process does for a keyframe, by the size of the map, and of closing a loop. Maps are made up: keyframes
// along a circle, landmarks seen by five in a row, descriptors at random, every word of the vocabulary as likely.
//
//   loop_benchmark --benchmark_min_time=0.5

#include <benchmark/benchmark.h>

#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>

#include "core/places/vocabulary.h"
#include "loop_process/loop_closer.h"
#include "loop_process/loop_correction.h"
#include "tests/support/feature_world.h"

namespace plslam::test {
namespace {

constexpr int kPoints = 300;
constexpr int kLines = 60;
constexpr int kSeenBy = 5;
constexpr double kStep_m = 0.5;

Descriptor DescriptorOf(uint64_t seed) {
  std::mt19937_64 generator(seed);
  return {generator(), generator(), generator(), generator()};
}

SE3 OnCircle(int i, int n) {
  const double a = 2.0 * std::numbers::pi * i / n;
  const double radius_m = kStep_m * n / (2.0 * std::numbers::pi);
  return {ExpSO3({0.0, a, 0.0}), {radius_m * (1.0 - std::cos(a)), 0.0, radius_m * std::sin(a)}};
}

/// A map of `n` keyframes, their features, and one more keyframe at its end.
struct MadeUpMap {
  explicit MadeUpMap(int n) {
    for (int i = 0; i < n; ++i) AddKeyframe(i, n);
    for (int i = 0; i < n; ++i) AddLandmarks(i, n);
  }

  void AddKeyframe(int i, int n) {
    MapKeyframe entry;
    entry.id = entry.session_keyframe_id = i;
    entry.session = 1;
    entry.T_w_kf = entry.T_odom_kf = OnCircle(i, n);
    if (i > 0) {
      entry.previous_id = entry.parent_id = i - 1;
      entry.T_prevkf_kf = OnCircle(i - 1, n).Inverse() * entry.T_w_kf;
      entry.relative_covariance = 1e-5 * Matrix6d::Identity();
    }
    map.Put(entry);
    Keyframe keyframe;
    keyframe.session = 1;
    keyframe.keyframe_id = i;
    keyframes.push_back(keyframe);
  }

  // A fifth of what a keyframe sees is new; it is in front of it and of the next ones.
  void AddLandmarks(int i, int n) {
    std::mt19937_64 generator(static_cast<uint64_t>(i) + 1);
    std::uniform_real_distribution<double> across(-1.0, 1.0);
    for (int k = 0; k < kPoints / kSeenBy; ++k) {
      MapPoint point;
      point.id = next_point++;
      point.p_w =
          OnCircle(i, n) * Eigen::Vector3d(2.0 * across(generator), across(generator), 6.0 + across(generator));
      point.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      point.descriptor = DescriptorOf(generator());
      for (int j = i; j < std::min(n, i + kSeenBy); ++j) SeePoint(j, point);
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

  void SeePoint(int j, MapPoint& point) {
    Keyframe& keyframe = keyframes[static_cast<size_t>(j)];
    const Eigen::Vector3d p_c = map.FindKeyframe(j)->T_w_kf.Inverse() * point.p_w;
    StereoPoint seen;
    const Eigen::Vector3d uvd = FeatureWorld::Camera().ProjectStereo(p_c);
    seen.left.px = uvd.head<2>();
    seen.disparity_px = uvd.z();
    seen.left.descriptor = point.descriptor;
    point.depth_m = p_c.z();
    point.sights.push_back({j, static_cast<int32_t>(keyframe.features.points.size())});
    keyframe.features.points.push_back(seen);
  }

  Map map;
  std::vector<Keyframe> keyframes;
  int64_t next_point = 0;
};

PlaceRecogniser Places() {
  return {Vocabulary::Load(PLSLAM_SOURCE_DIR "/config/orb.vocabulary"),
          Vocabulary::Load(PLSLAM_SOURCE_DIR "/config/lbd.vocabulary"), PlaceOptions()};
}

/// Loop closer that has been shown all but the last keyframe of a map, and the map.
struct Shown {
  explicit Shown(int n) : world(n), closer(FeatureWorld::Camera(), Places(), {}) {
    for (const Keyframe& keyframe : world.keyframes) closer.AddKeyframe(keyframe);
    closer.Follow(world.map);
    last = world.keyframes.back();
    world.keyframes.clear();
  }

  MadeUpMap world;
  LoopCloser closer;
  Keyframe last;
};

Shown& ShownOf(int n) {
  static std::unique_ptr<Shown> shown;
  static int size = 0;
  if (size != n) shown.reset();
  if (!shown) shown = std::make_unique<Shown>(n);
  size = n;
  return *shown;
}

void BM_Judge(benchmark::State& state) {
  Shown& shown = ShownOf(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    // Comes anew each time, so that it is described each time.
    shown.closer.AddKeyframe(shown.last);
    benchmark::DoNotOptimize(shown.closer.Judge(shown.world.map, 1, shown.last.keyframe_id));
  }
  state.counters["looked_at"] = static_cast<double>(shown.closer.last_search().evidence.size());
}
BENCHMARK(BM_Judge)->Arg(100)->Arg(300)->Arg(1000)->Arg(3000)->Arg(10000)->Unit(benchmark::kMillisecond);

void BM_CloseLoop(benchmark::State& state) {
  const int n = static_cast<int>(state.range(0));
  MadeUpMap world(n);
  // What drift has done: every step a little wrong in the same way.
  Vector6d error;
  error << 1e-3, 5e-4, -1e-3, 1e-4, 2e-4, -1e-4;
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
  for (auto _ : state) closed = CloseLoop(world.map, loop, {}).has_value();
  state.counters["closed"] = closed ? 1 : 0;
}
BENCHMARK(BM_CloseLoop)->Arg(100)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plslam::test

BENCHMARK_MAIN();
