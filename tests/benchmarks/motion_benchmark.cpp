// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "core/motion/motion_estimator.h"
#include "core/motion/pose_ransac.h"
#include "tests/unit/motion/motion_world.h"

namespace plslam {
namespace {

constexpr test::MotionNoise kNoise{0.5, 0.6, 0.4};

// A tenth of all matches is wrong.
test::MotionWorld MakeWorld(int n_points, int n_lines) {
  test::MotionWorldMaker maker(1);
  test::MotionWorld world = maker.Make(n_points, n_lines, kNoise);
  for (int i = 0; i < n_points / 10; ++i) {
    world.points[i].uvd = world.camera.ProjectStereo(maker.PointInView(world.camera));
  }
  return world;
}

void BM_EstimateMotion(benchmark::State& state) {
  const test::MotionWorld world = MakeWorld(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  int iterations = 0;
  for (auto _ : state) {
    const auto estimate =
        EstimateMotion(world.points, world.lines, world.camera, SE3(), std::nullopt, MotionOptions());
    iterations = estimate ? estimate->iterations : -1;
    benchmark::DoNotOptimize(iterations);
  }
  state.counters["iterations"] = iterations;
}
BENCHMARK(BM_EstimateMotion)->Args({400, 100})->Args({400, 0})->Args({0, 100})->Unit(benchmark::kMicrosecond);

void BM_EstimatePoseRansac(benchmark::State& state) {
  const test::MotionWorld world = MakeWorld(400, 100);
  for (auto _ : state) {
    benchmark::DoNotOptimize(EstimatePoseRansac(world.points, world.lines, world.camera, 50, 2.0, 1));
  }
}
BENCHMARK(BM_EstimatePoseRansac)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace plslam

BENCHMARK_MAIN();
