// SPDX-License-Identifier: BSD-3-Clause
// Our solvers beside Ceres with the reference cost functions, from the same start to the same tolerance
// (docs/lab/refine.md).
#include <benchmark/benchmark.h>
#include <string>
#include <variant>
#include <vector>

#include "core/optim/pose_graph/pose_graph.h"
#include "core/optim/pose_graph/pose_graph_check.h"
#include "core/optim/pose_graph/pose_graph_chordal.h"
#include "core/process/process_usage.h"
#include "tests/support/data_folder.h"
#include "tests/unit/optim/bundle_world.h"
#include "tests/unit/optim/pose_graph_world.h"
#include "tests/unit/reference/reference_graph.h"
#include "tests/unit/reference/reference_window.h"
#include "tools/pose_graph/g2o.h"
#include "tools/pose_graph/pose_graph_chain.h"

namespace plslam {
namespace {

constexpr double kTolerance = 1e-6;
// `peak_MB` below is that of a solver only if it runs alone (--benchmark_filter).

test::BundleWorld Window(int poses) {
  test::BundleWorldSpec spec;
  spec.fixed_poses = 1;
  spec.free_poses = poses - 1;
  spec.points = 100 * poses;
  spec.lines = 15 * poses;
  spec.start_m = 0.005;
  spec.start_rad = 0.001;
  return test::MakeBundleWorld(spec, 1);
}

void BM_WindowByOurs(benchmark::State& state) {
  const test::BundleWorld world = Window(static_cast<int>(state.range(0)));
  BundleOptions options;
  options.max_iterations = 50;
  options.max_refinements = 0;
  options.function_tolerance = kTolerance;
  BundleResult result;
  for (auto _ : state) {
    result = AdjustBundle(world.problem, options, nullptr, BundleCovariances::kNone);
    benchmark::DoNotOptimize(result.iterations);
  }
  state.counters["iterations"] = result.iterations;
  state.counters["peak_MB"] = bus::PeakMemory_mb();
  state.counters["cost"] = test::ReferenceWindow(world.problem, false, options.huber_delta).CostAt(result, false);
}
BENCHMARK(BM_WindowByOurs)->Arg(11)->Arg(50)->Arg(150)->Arg(1342)->Arg(10000)->Unit(benchmark::kMillisecond);

void WindowByCeres(benchmark::State& state, ceres::LinearSolverType solver) {
  const test::BundleWorld world = Window(static_cast<int>(state.range(0)));
  ceres::Solver::Options options;
  options.linear_solver_type = solver;
  options.preconditioner_type = ceres::CLUSTER_JACOBI;
  options.num_threads = static_cast<int>(state.range(1));
  options.max_num_iterations = 50;
  options.function_tolerance = kTolerance;
  ceres::Solver::Summary summary;
  for (auto _ : state) {
    state.PauseTiming();
    test::ReferenceWindow window(world.problem, false, BundleOptions{}.huber_delta);
    state.ResumeTiming();
    summary = window.Solve(options);
  }
  state.counters["iterations"] = static_cast<double>(summary.iterations.size()) - 1.0;
  state.counters["peak_MB"] = bus::PeakMemory_mb();
  state.counters["cost"] = summary.final_cost;
}
void BM_WindowByDenseSchur(benchmark::State& state) { WindowByCeres(state, ceres::DENSE_SCHUR); }
void BM_WindowBySparseSchur(benchmark::State& state) { WindowByCeres(state, ceres::SPARSE_SCHUR); }
void BM_WindowByIterativeSchur(benchmark::State& state) { WindowByCeres(state, ceres::ITERATIVE_SCHUR); }
BENCHMARK(BM_WindowByDenseSchur)->ArgsProduct({{11, 50, 150}, {1, 2}})->Unit(benchmark::kMillisecond);
BENCHMARK(BM_WindowBySparseSchur)->ArgsProduct({{11, 50, 150, 1342, 10000}, {1, 2}})->Unit(benchmark::kMillisecond);
BENCHMARK(BM_WindowByIterativeSchur)
    ->ArgsProduct({{11, 50, 150, 1342, 10000}, {1, 2}})
    ->Unit(benchmark::kMillisecond);

const char* const kGraphs[] = {"parking-garage", "sphere2500", "intel", "manhattan"};

/// The graph at the start that both solvers have: the chordal relaxation.
template <class Pose>
std::vector<Pose> ChordalStart(const PoseGraph<Pose>& graph) {
  const std::vector<bool> none(graph.edges.size(), false);
  return ChordalPoses(graph, ConstantPoses(graph, none)).value();
}

template <class Solve>
void SolveGraph(benchmark::State& state, const Solve& solve) {
  const std::string name = kGraphs[state.range(0)];
  state.SetLabel(name);
  const auto folder = test::DataFolder("posegraphs");
  if (!folder) return state.SkipWithError("no data");
  pose_graph::G2oFile file = pose_graph::ReadG2o((*folder / (name + ".g2o")).string());
  std::visit([&](auto& content) { solve(content.graph, ChordalStart(content.graph)); }, file.content);
}

template <class Pose>
void GraphByOurs(benchmark::State& state, PoseGraph<Pose> graph, const std::vector<Pose>& start) {
  for (size_t i = 0; i < start.size(); ++i) graph.poses[i].T_w_kf = start[i];
  PoseGraphOptions options;
  options.max_iterations = 50;
  options.function_tolerance = kTolerance;
  PoseGraphSolution<Pose> result;
  for (auto _ : state) result = OptimisePoseGraph(graph, options);
  state.counters["cost"] = 0.5 * result.chi2_after;
  state.counters["iterations"] = result.iterations;
  state.counters["peak_MB"] = bus::PeakMemory_mb();
}

/// CHOLMOD is the sparse library of SPARSE_NORMAL_CHOLESKY.
template <class Pose>
void GraphByCeres(benchmark::State& state, const PoseGraph<Pose>& graph, const std::vector<Pose>& start) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = static_cast<int>(state.range(1));
  options.max_num_iterations = 50;
  options.function_tolerance = kTolerance;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  for (auto _ : state) {
    state.PauseTiming();
    test::ReferenceGraph<Pose> reference(graph, start);
    state.ResumeTiming();
    ceres::Solve(options, &reference.problem(), &summary);
  }
  state.counters["cost"] = summary.final_cost;
  state.counters["iterations"] = static_cast<double>(summary.iterations.size()) - 1.0;
  state.counters["peak_MB"] = bus::PeakMemory_mb();
  state.counters["factor_s"] = summary.linear_solver_time_in_seconds;
}

void BM_GraphByOurs(benchmark::State& state) {
  SolveGraph(state, [&state](auto& graph, const auto& start) { GraphByOurs(state, graph, start); });
}
BENCHMARK(BM_GraphByOurs)->DenseRange(0, 3)->Unit(benchmark::kMillisecond);

void BM_GraphByCeres(benchmark::State& state) {
  SolveGraph(state, [&state](auto& graph, const auto& start) { GraphByCeres(state, graph, start); });
}
BENCHMARK(BM_GraphByCeres)->ArgsProduct({{0, 1, 2, 3}, {1, 2}})->Unit(benchmark::kMillisecond);

/// Laps of 1000 keyframes, each with edges to the six before it and to the lap before.
template <class Solve>
void SolveLargeGraph(benchmark::State& state, const Solve& solve) {
  auto world = test::MakePoseGraphWorld<SE3>({.poses = static_cast<int>(state.range(0)), .lap = 1000, .reach = 6});
  for (PoseGraphMotion<SE3>& edge : world.graph.edges) edge.robust = false;
  state.counters["edges"] = static_cast<double>(world.graph.edges.size());
  solve(world.graph, ChordalStart(world.graph));
}

void BM_LargeGraphByOurs(benchmark::State& state) {
  SolveLargeGraph(state, [&state](auto& graph, const auto& start) { GraphByOurs(state, graph, start); });
}
BENCHMARK(BM_LargeGraphByOurs)->Arg(10'000)->Arg(100'000)->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

void BM_LargeGraphByCeres(benchmark::State& state) {
  SolveLargeGraph(state, [&state](auto& graph, const auto& start) { GraphByCeres(state, graph, start); });
}
BENCHMARK(BM_LargeGraphByCeres)
    ->ArgsProduct({{10'000, 100'000}, {1, 2}})
    ->MeasureProcessCPUTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plslam

BENCHMARK_MAIN();
