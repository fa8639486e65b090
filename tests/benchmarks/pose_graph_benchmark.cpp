// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <memory>

#include <benchmark/benchmark.h>

#include "core/io/maps/map_file.h"
#include "core/optim/pose_graph/pose_graph.h"
#include "tests/unit/map_file/stored_maps.h"
#include "tests/unit/optim/pose_graph_world.h"

namespace plslam {
namespace {

/// Keyframes with edges to the six before them, in laps of 100, as a map that is to be closed.
test::PoseGraphWorld<SE3> ClosingMap(int keyframes) {
  return test::MakePoseGraphWorld<SE3>({.poses = keyframes, .lap = 100, .reach = 6});
}

void Count(benchmark::State& state, const PoseGraphProblem& graph, const PoseGraphResult& result) {
  state.counters["edges"] = static_cast<double>(graph.edges.size());
  state.counters["iterations"] = result.iterations;
  state.counters["rejected"] = static_cast<double>(std::count(result.rejected.begin(), result.rejected.end(), true));
}

void BM_PoseGraph(benchmark::State& state) {
  const auto world = ClosingMap(static_cast<int>(state.range(0)));
  PoseGraphResult result;
  for (auto _ : state) result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  Count(state, world.graph, result);
}
BENCHMARK(BM_PoseGraph)->Arg(100)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

void BM_PoseGraphWithAWrongLoop(benchmark::State& state) {
  auto world = ClosingMap(static_cast<int>(state.range(0)));
  const SE3 wrong(Eigen::Quaterniond(0.8, 0.0, 0.6, 0.0), {1.0, 2.0, 0.0});
  world.graph.edges.push_back(test::MakeEdge<SE3>({}, 10, 450, wrong, true));
  PoseGraphResult result;
  for (auto _ : state) result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  Count(state, world.graph, result);
}
BENCHMARK(BM_PoseGraphWithAWrongLoop)->Arg(500)->Unit(benchmark::kMillisecond);

void BM_PoseGraphCovariances(benchmark::State& state) {
  const auto world = ClosingMap(static_cast<int>(state.range(0)));
  const PoseGraphResult result = OptimisePoseGraph(world.graph, PoseGraphOptions());
  for (auto _ : state) benchmark::DoNotOptimize(PoseGraphCovariances(world.graph, result));
}
BENCHMARK(BM_PoseGraphCovariances)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

void BM_LoadMap(benchmark::State& state) {
  const std::string path = "pose_graph_benchmark.plmap";
  WriteMapFile(path, test::LongStoredMap(static_cast<int>(state.range(0)), 1000, 100));
  MapTotals totals;
  for (auto _ : state) {
    auto stored = std::make_unique<StoredMap>(ReadMapFile(path));
    state.PauseTiming();  // not the time to free it
    totals = stored->map.Totals();
    stored.reset();
    state.ResumeTiming();
  }
  std::remove(path.c_str());
  state.counters["points"] = static_cast<double>(totals.points);
  state.counters["lines"] = static_cast<double>(totals.lines);
  state.counters["observations"] = static_cast<double>(totals.point_observations + totals.line_observations);
}
BENCHMARK(BM_LoadMap)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

void BM_EncodeMap(benchmark::State& state) {
  const StoredMap stored = test::LongStoredMap(static_cast<int>(state.range(0)), 1000, 100);
  size_t bytes = 0;
  for (auto _ : state) bytes = EncodeMap(stored).size();
  state.counters["MB"] = 1e-6 * static_cast<double>(bytes);
}
BENCHMARK(BM_EncodeMap)->Arg(500)->Arg(2000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plslam

BENCHMARK_MAIN();
