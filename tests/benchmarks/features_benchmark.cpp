// SPDX-License-Identifier: BSD-3-Clause
// Extraction and matching of features on real pairs if they are available, else on a generated texture. One thread.
// EuRoC's pair is not rectified: good for timing all stages, not for counting its stereo matches.
#include <atomic>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/features/feature_extractor.h"
#include "core/features/matching/descriptor_matcher.h"
#include "core/features/points/orb_extractor.h"
#include "core/io/images/image_file.h"
#include "tests/support/data_folder.h"
#include "vo_process/stereo/point_stereo.h"
#include "vo_process/stereo/stereo_matcher.h"

namespace plslam {
namespace {

struct Pair {
  cv::Mat left;
  cv::Mat right;
};

/// Blurred random pixels; the right image is the left one moved by 20 pixels.
Pair GeneratedPair(int width_px, int height_px) {
  std::mt19937 random(1);
  cv::Mat wide(height_px, width_px + 20, CV_8UC1);
  for (int y = 0; y < wide.rows; ++y) {
    for (int x = 0; x < wide.cols; ++x) wide.at<uint8_t>(y, x) = static_cast<uint8_t>(random() & 255U);
  }
  cv::GaussianBlur(wide, wide, cv::Size(9, 9), 2.0);
  cv::normalize(wide, wide, 0, 255, cv::NORM_MINMAX);
  return {wide(cv::Rect(0, 0, width_px, height_px)).clone(), wide(cv::Rect(20, 0, width_px, height_px)).clone()};
}

Pair ReadPair(const std::string& sequence, const std::string& left, const std::string& right) {
  const auto folder = test::DataFolder(sequence);
  if (!folder) return {};
  return {ReadGreyImage(*folder / left), ReadGreyImage(*folder / right)};
}

const Pair& PairFor(int which) {
  static const std::vector<Pair> kPairs = [] {
    cv::setNumThreads(1);
    std::vector<Pair> pairs(2);
    pairs[0] = ReadPair("kitti_03", "image_0/000000.png", "image_1/000000.png");
    if (const auto folder = test::DataFolder("euroc_MH_01_a")) {
      std::vector<cv::String> names;
      cv::glob((*folder / "mav0/cam0/data/*.png").string(), names);
      if (!names.empty()) {
        const std::string name = std::filesystem::path(names.front()).filename();
        pairs[1] = ReadPair("euroc_MH_01_a", "mav0/cam0/data/" + name, "mav0/cam1/data/" + name);
      }
    }
    if (pairs[0].left.empty() || pairs[0].right.empty()) pairs[0] = GeneratedPair(1241, 376);
    if (pairs[1].left.empty() || pairs[1].right.empty()) pairs[1] = GeneratedPair(752, 480);
    return pairs;
  }();
  return kPairs[which];
}

const char* NameOf(int which) { return which == 0 ? "kitti" : "euroc"; }

void ExtractPoints(benchmark::State& state) {
  const int which = static_cast<int>(state.range(0));
  const Pair& pair = PairFor(which);
  OrbExtractor extractor{OrbOptions{}};
  size_t count = 0;
  for (auto _ : state) count = extractor.Extract(pair.left).size();
  state.SetLabel(NameOf(which));
  state.counters["points"] = static_cast<double>(count);
}

void ExtractBoth(benchmark::State& state) {
  const int which = static_cast<int>(state.range(0));
  const Pair& pair = PairFor(which);
  FeatureExtractor extractor{FeatureOptions{}};
  for (auto _ : state) benchmark::DoNotOptimize(extractor.Extract(pair.left));
  state.SetLabel(NameOf(which));
}

void MatchPointsInStereo(benchmark::State& state) {
  const int which = static_cast<int>(state.range(0));
  const Pair& pair = PairFor(which);
  StereoOptions options;
  options.point_direct = state.range(1) != 0;
  OrbExtractor extractor{OrbOptions{}};
  const std::vector<StereoPoint> left = vo::WithoutDepth(extractor.Extract(pair.left), options);
  const std::vector<PointFeature> right = extractor.Extract(pair.right);
  double matched = 0.0;
  for (auto _ : state) {
    std::vector<StereoPoint> points = left;
    std::atomic<size_t> begun = 0;
    vo::MatchPointsStereo(points, right, vo::FindPointCandidates(points, right, vo::PairSkew(), options),
                          vo::HalvedPair(pair.left, pair.right), vo::RowField(), options, begun);
    matched = 0.0;
    for (const StereoPoint& p : points) matched += p.HasDepth() ? 1.0 : 0.0;
  }
  state.SetLabel(NameOf(which));
  state.counters["matched"] = matched;
}

void MatchByProjection(benchmark::State& state) {
  OrbExtractor extractor{OrbOptions{}};
  const std::vector<PointFeature> points = extractor.Extract(PairFor(1).left);
  std::vector<PointQuery> queries;
  for (const PointFeature& p : points) queries.push_back({p.px, 15.0, p.octave, p.angle_rad, p.descriptor});
  for (auto _ : state) {
    const PointGrid grid(points);
    benchmark::DoNotOptimize(MatchPointsByProjection(queries, grid, {}));
  }
}

void MatchByBruteForce(benchmark::State& state) {
  OrbExtractor extractor{OrbOptions{}};
  const std::vector<PointFeature> a = extractor.Extract(PairFor(1).left);
  const std::vector<PointFeature> b = extractor.Extract(PairFor(1).right);
  for (auto _ : state) benchmark::DoNotOptimize(MatchPointsBruteForce(a, b, {}));
}

template <class Benchmark>
void Medians(Benchmark* b) {
  b->Unit(benchmark::kMillisecond)->Repetitions(5)->ReportAggregatesOnly(true);
}

}  // namespace
}  // namespace plslam

int main(int argc, char** argv) {
  using plslam::Medians;
  Medians(benchmark::RegisterBenchmark("points/extract", plslam::ExtractPoints)->Arg(0)->Arg(1));
  Medians(benchmark::RegisterBenchmark("both/extract", plslam::ExtractBoth)->Arg(0)->Arg(1));
  Medians(benchmark::RegisterBenchmark("points/stereo", plslam::MatchPointsInStereo)->Args({0, 0})->Args({0, 1}));
  Medians(benchmark::RegisterBenchmark("points/projection", plslam::MatchByProjection));
  Medians(benchmark::RegisterBenchmark("points/brute_force", plslam::MatchByBruteForce));
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
