// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include "core/optim/bundle/bundle.h"
#include "tests/unit/optim/bundle_world.h"

namespace plslam {
namespace {

// A local map near its optimum: half of the poses hold the others, one observation in fifty is wrong.
test::BundleWorldSpec LocalMap() {
  test::BundleWorldSpec spec;
  spec.fixed_poses = 8;
  spec.free_poses = 8;
  spec.points = 1200;
  spec.lines = 200;
  spec.start_m = 0.005;
  spec.start_rad = 0.001;
  spec.outliers = 0.02;
  return spec;
}

void Adjust(benchmark::State& state, const test::BundleWorldSpec& spec, LineParameters lines) {
  const test::BundleWorld world = test::MakeBundleWorld(spec, 1);
  BundleOptions options;
  options.lines = lines;
  BundleResult result;
  for (auto _ : state) {
    result = AdjustBundle(world.problem, options);
    benchmark::DoNotOptimize(result.iterations);
  }
  const test::BundleErrors errors = test::ErrorsOf(world, result);
  state.counters["iterations"] = result.iterations;
  state.counters["rms_before"] = result.before.normalised;
  state.counters["pose_mm"] = 1e3 * errors.translation_m;
}

void BM_LocalMap(benchmark::State& state) { Adjust(state, LocalMap(), LineParameters::kMinimal); }
BENCHMARK(BM_LocalMap)->Unit(benchmark::kMillisecond);

void BM_LocalMapByEndpoints(benchmark::State& state) { Adjust(state, LocalMap(), LineParameters::kEndpoints); }
BENCHMARK(BM_LocalMapByEndpoints)->Unit(benchmark::kMillisecond);

void BM_WholeMap(benchmark::State& state) {
  test::BundleWorldSpec spec = LocalMap();
  spec.fixed_poses = 1;
  spec.free_poses = static_cast<int>(state.range(0));
  spec.points = 100 * spec.free_poses;
  spec.lines = 15 * spec.free_poses;
  Adjust(state, spec, LineParameters::kMinimal);
}
BENCHMARK(BM_WholeMap)->Arg(100)->Arg(300)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plslam

BENCHMARK_MAIN();
