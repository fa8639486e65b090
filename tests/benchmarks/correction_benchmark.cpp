// SPDX-License-Identifier: BSD-3-Clause
#include <cstddef>
#include <cstdio>
#include <string>

#include <benchmark/benchmark.h>

#include "core/bus/messages/map_pages.h"
#include "mapping_process/corrections/correction.h"
#include "tests/unit/mapping/loop_world.h"

// Cost of a loop correction in mapping_process, with a map of 500 keyframes and 30,000 points.

namespace plslam {
namespace {

constexpr double kRadius_m = 39.0;
constexpr double kStep_m = 0.5;

struct Drifted {
  Drifted() : walk(test::MakeWalk(world, test::RingPath(kRadius_m, kStep_m, 500), Options())) {
    for (const Keyframe& keyframe : walk.keyframes) test::MapOne(keyframe, mapper);
    mapper.Correct(test::Drift(mapper.map()), &reason);
    mapper.TakeUpdate();
    const MapTotals totals = mapper.map().Totals();
    std::printf("%ld keyframes, %ld points, %ld lines, %ld and %ld observations\n", totals.keyframes, totals.points,
                totals.lines, totals.point_observations, totals.line_observations);
  }
  static test::WalkOptions Options() {
    test::WalkOptions options;
    options.with_ids = false;
    return options;
  }
  static mapping::MappingOptions WithoutCulling() {
    mapping::MappingOptions options;
    options.culling.redundant_share = 1.01;
    return options;
  }

  test::FeatureWorld world = test::MakeRing(kRadius_m, 29'000, 2'500, 3);
  test::Walk walk;
  mapping::Mapper mapper{test::FeatureWorld::Camera(), WithoutCulling()};
  std::string reason;
};

const Drifted& MapOnce() {
  static const Drifted map;
  return map;
}

void Correct(benchmark::State& state, const LoopClosure& closure) {
  for (auto _ : state) {
    state.PauseTiming();
    mapping::Mapper mapper = MapOnce().mapper;
    std::string reason;
    state.ResumeTiming();
    if (!mapper.Correct(closure, &reason)) state.SkipWithError(reason.c_str());
    state.PauseTiming();
    double bytes = 0.0;
    for (const map_update_t& page : bus::CutIntoPages(mapper.TakeUpdate(), 60'000)) bytes += page.getEncodedSize();
    state.counters["update_kB"] = 1e-3 * bytes;
    state.counters["error_m"] = test::PositionError_m(mapper.map(), MapOnce().walk.T_w_c);
    const std::vector<double> errors_m = test::PointErrors_m(mapper.map(), MapOnce().world);
    state.counters["point_error_m"] = errors_m[errors_m.size() / 2];
    state.counters["reprojection_px"] = test::Reprojection_px(mapper.map(), MapOnce().walk.keyframes);
    state.ResumeTiming();
  }
}

void BM_Loop(benchmark::State& state) {
  Correct(state,
          test::CloseByTruth(MapOnce().mapper.map(), test::RevisitOf(MapOnce().mapper.map(), MapOnce().walk.T_w_c),
                             MapOnce().walk.T_w_c));
}
BENCHMARK(BM_Loop)->Unit(benchmark::kMillisecond)->Iterations(3);

void BM_Adjustment(benchmark::State& state) {
  Correct(state, test::AdjustByTruth(MapOnce().mapper.map(), MapOnce().walk.T_w_c));
}
BENCHMARK(BM_Adjustment)->Unit(benchmark::kMillisecond)->Iterations(3);

/// The part of both that moves keyframes and landmarks: the cost of an adjustment without triangulating landmarks
/// again.
void BM_Move(benchmark::State& state) {
  const LoopClosure closure = test::AdjustByTruth(MapOnce().mapper.map(), MapOnce().walk.T_w_c);
  KeyframeFeatures features;
  for (const Keyframe& keyframe : MapOnce().walk.keyframes)
    features[KeyframeId(keyframe.name.number)] = keyframe.features;
  for (auto _ : state) {
    state.PauseTiming();
    plslam::Map map = MapOnce().mapper.map();
    state.ResumeTiming();
    mapping::MoveKeyframes(mapping::PosesAfter(closure.poses, map), features, test::FeatureWorld::Camera(), map);
    state.PauseTiming();
    const std::vector<double> errors_m = test::PointErrors_m(map, MapOnce().world);
    state.counters["point_error_m"] = errors_m[errors_m.size() / 2];
    state.counters["reprojection_px"] = test::Reprojection_px(map, MapOnce().walk.keyframes);
    state.ResumeTiming();
  }
}
BENCHMARK(BM_Move)->Unit(benchmark::kMillisecond)->Iterations(3);

}  // namespace
}  // namespace plslam

BENCHMARK_MAIN();
