// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <benchmark/benchmark.h>

#include "core/datasets/synthetic/simulator.h"

namespace plslam::synthetic {
namespace {

// A stereo pair; CPU time counts both threads.
void RenderPair(benchmark::State& state, const std::string& description) {
  const Simulator simulator(ParseOptions(description));
  int index = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(simulator.Render(index));
    index = (index + 17) % simulator.size();
  }
}

BENCHMARK_CAPTURE(RenderPair, room, "room")->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderPair, corridor, "corridor")->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderPair, street, "street")->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderPair, whitewall, "whitewall")->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(RenderPair, distorted, "room?distorted=1")->MeasureProcessCPUTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plslam::synthetic
