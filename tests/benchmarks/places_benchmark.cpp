// SPDX-License-Identifier: BSD-3-Clause
// Place recognition with up to 10,000 keyframes of 1,500 points and 150 lines, and the default vocabularies. The
// keyframes are synthetic: words with the frequencies of the training images, descriptors a few bits from the words'
// centres. One thread.
//
//   places_benchmark --growth FILE.png   draws the CPU time of a query over the number of keyframes instead
#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <random>
#include <string_view>

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include "core/places/place_recogniser.h"
#include "tests/support/data_folder.h"
#include "tools/evaluate/drawing/axes.h"

namespace plslam {
namespace {

constexpr int kPoints = 1500;
constexpr int kLines = 150;

Vocabulary Load(const char* name) { return Vocabulary::Load(test::SourceFolder() / "config" / name); }

/// Draws descriptors whose words have the frequencies of the vocabulary.
class DescriptorSource {
 public:
  explicit DescriptorSource(const VocabularyTree& tree) : tree_(tree) {
    double sum = 0.0;
    for (int node = 0; node < tree.nodes(); ++node) {
      if (tree.word[node] < 0) continue;
      leaves_.push_back(node);
      sum += std::exp(-static_cast<double>(tree.idf[tree.word[node]]));
      cumulated_.push_back(sum);
    }
  }

  Descriptor Draw(std::mt19937_64& random) const {
    const double at = 0x1p-53 * static_cast<double>(random() >> 11) * cumulated_.back();
    const auto leaf = std::upper_bound(cumulated_.begin(), cumulated_.end(), at) - cumulated_.begin();
    Descriptor descriptor = tree_.centers[leaves_[leaf]];
    for (int i = 0; i < 5; ++i) descriptor[random() % 4] ^= uint64_t{1} << (random() % 64);
    return descriptor;
  }

 private:
  const VocabularyTree& tree_;
  std::vector<int> leaves_;
  std::vector<double> cumulated_;
};

/// Keyframes without end, the same at every run.
class KeyframeSource {
 public:
  explicit KeyframeSource(const PlaceRecogniser& places)
      : points_(places.point_vocabulary().tree()), lines_(places.line_vocabulary().tree()) {}

  ImageFeatures Next() {
    ImageFeatures features;
    features.points.resize(kPoints);
    features.lines.resize(kLines);
    for (PointFeature& point : features.points) point = {.px = DrawPixel(), .descriptor = points_.Draw(random_)};
    for (LineFeature& line : features.lines) {
      line.segment = {DrawPixel(), DrawPixel()};
      line.descriptor = lines_.Draw(random_);
    }
    return features;
  }

 private:
  Eigen::Vector2d DrawPixel() { return {static_cast<double>(random_() % 752), static_cast<double>(random_() % 480)}; }

  std::mt19937_64 random_{1};
  DescriptorSource points_;
  DescriptorSource lines_;
};

/// One recogniser that grows as the benchmarks need more keyframes.
struct World {
  PlaceRecogniser places{Load("orb.vocabulary"), Load("lbd.vocabulary"), PlaceOptions{}};
  KeyframeSource source{places};

  void GrowTo(int keyframes) {
    while (places.size() < keyframes) places.Add(places.size(), places.Describe(source.Next()));
  }
};

World& TheWorld() {
  static World world;
  return world;
}

void LoadVocabularies(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(Load("orb.vocabulary").words());
    benchmark::DoNotOptimize(Load("lbd.vocabulary").words());
  }
}

void Describe(benchmark::State& state) {
  World& world = TheWorld();
  std::vector<ImageFeatures> features;
  for (int i = 0; i < 16; ++i) features.push_back(world.source.Next());
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(world.places.Describe(features[i++ % features.size()]));
}

std::vector<PlaceDescription> Queries(World& world) {
  std::vector<PlaceDescription> queries;
  for (int i = 0; i < 16; ++i) queries.push_back(world.places.Describe(world.source.Next()));
  return queries;
}

std::vector<PlaceMatch> Ask(const World& world, const PlaceDescription& query) {
  const int64_t newest = world.places.size();
  return world.places.Query(
      query, [newest](KeyframeId id) { return id.value > newest - 20; }, 10);
}

void Query(benchmark::State& state) {
  World& world = TheWorld();
  world.GrowTo(static_cast<int>(state.range(0)));
  const std::vector<PlaceDescription> queries = Queries(world);
  size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(Ask(world, queries[i++ % queries.size()]));
}

void RemoveAndAdd(benchmark::State& state) {
  World& world = TheWorld();
  world.GrowTo(static_cast<int>(state.range(0)));
  int id = 0;
  for (auto _ : state) {
    const PlaceDescription description = world.places.Of(id);
    world.places.Remove(id);
    world.places.Add(id, description);
    id = (id + 37) % static_cast<int>(state.range(0));
  }
}

/// CPU time of this thread, without other programs on the machine.
double CpuTime_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double MedianQuery_ms(World& world) {
  const std::vector<PlaceDescription> queries = Queries(world);
  std::vector<double> times_ms;
  for (int i = 0; i < 101; ++i) {
    const double start_ms = CpuTime_ms();
    benchmark::DoNotOptimize(Ask(world, queries[i % queries.size()]));
    times_ms.push_back(CpuTime_ms() - start_ms);
  }
  std::nth_element(times_ms.begin(), times_ms.begin() + 50, times_ms.end());
  return times_ms[50];
}

int DrawGrowth(const std::string& path) {
  std::vector<Eigen::Vector2d> growth;
  for (const int keyframes : {100, 300, 1000, 2000, 3000, 4500, 6000, 8000, 10000}) {
    TheWorld().GrowTo(keyframes);
    growth.emplace_back(keyframes, MedianQuery_ms(TheWorld()));
    fmt::print("{:6} keyframes: {:.3f} ms\n", keyframes, growth.back().y());
  }
  const evaluate::Stroke stroke{{20, 90, 190}, 1.0, false};
  evaluate::Drawing drawing;
  drawing.size = {evaluate::kColumn_pt, 150.0};
  evaluate::Axes axes(drawing, {{30.0, 14.0}, {evaluate::kColumn_pt - 36.0, 112.0}}, {0.0, 10500.0},
                      {0.0, 1.15 * growth.back().y()});
  axes.DrawGrid("keyframes in the index; query and merge, median", "CPU time [ms]");
  axes.DrawPath(growth, stroke);
  axes.DrawDots(growth, 2.0, stroke.ink);
  axes.DrawFrame();
  evaluate::WriteDrawing(path, drawing);
  return 0;
}

template <class Benchmark>
void Medians(Benchmark* b) {
  b->Unit(benchmark::kMillisecond)->Repetitions(5)->ReportAggregatesOnly(true);
}

}  // namespace
}  // namespace plslam

int main(int argc, char** argv) {
  using plslam::Medians;
  if (argc == 3 && std::string_view(argv[1]) == "--growth") return plslam::DrawGrowth(argv[2]);
  Medians(benchmark::RegisterBenchmark("places/load_vocabularies", plslam::LoadVocabularies));
  Medians(benchmark::RegisterBenchmark("places/describe", plslam::Describe));
  Medians(benchmark::RegisterBenchmark("places/query", plslam::Query)->Arg(100)->Arg(1000)->Arg(10000));
  Medians(benchmark::RegisterBenchmark("places/remove_and_add", plslam::RemoveAndAdd)->Arg(1000)->Arg(10000));
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
