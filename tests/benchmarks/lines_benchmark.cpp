// SPDX-License-Identifier: BSD-3-Clause
// Stages of the line front end on real images, or on a drawn one where those are absent.
#include <filesystem>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/features/image/gradients.h"
#include "core/features/lines/lbd.h"
#include "core/features/lines/line_detector.h"
#include "core/features/lines/line_extractor.h"
#include "core/features/matching/line_matcher.h"
#include "core/io/images/image_file.h"
#include "tests/support/data_folder.h"
#include "vo_process/stereo/line_stereo.h"

namespace plslam {
namespace {

struct Scene {
  const char* name;
  const char* folder;
  const char* left;
  const char* right;
  cv::Size size;
};

const Scene kScenes[] = {
    {"kitti", "kitti_03", "image_0/000030.png", "image_1/000030.png", {1242, 375}},
    {"euroc",
     "euroc_MH_01_a",
     "mav0/cam0/data/1403636584763555584.png",
     "mav0/cam1/data/1403636584763555584.png",
     {752, 480}},
};

cv::Mat Drawn(cv::Size size, int shift) {
  cv::Mat image(size, CV_8UC1, cv::Scalar(90));
  cv::RNG random(7);
  for (int i = 0; i < 150; ++i) {
    const cv::Point p(random.uniform(0, size.width) - shift, random.uniform(0, size.height));
    const cv::Point q = p + cv::Point(random.uniform(10, 120), random.uniform(10, 120));
    cv::rectangle(image, p, q, cv::Scalar(random.uniform(0, 255)), random.uniform(-1, 4), cv::LINE_AA);
  }
  return image;
}

cv::Mat Load(const Scene& scene, bool left) {
  const auto folder = test::DataFolder(scene.folder);
  cv::Mat image;
  if (folder) image = ReadGreyImage(*folder / (left ? scene.left : scene.right));
  return image.empty() ? Drawn(scene.size, left ? 0 : 15) : image;
}

LineOptions WithDetector(Segments detector) {
  LineOptions options;
  options.detector = detector;
  return options;
}

void Detect(benchmark::State& state, const Scene& scene, Segments detector) {
  const cv::Mat image = Load(scene, true);
  const auto lines = MakeLineDetector(WithDetector(detector));
  Gradients gradients;
  size_t found = 0;
  for (auto _ : state) {
    ComputeGradients(image, gradients);
    found = lines->Detect(image, gradients).size();
  }
  state.counters["segments"] = static_cast<double>(found);
}

void Extract(benchmark::State& state, const Scene& scene, Segments detector) {
  const cv::Mat image = Load(scene, true);
  LineExtractor extractor(WithDetector(detector));
  size_t found = 0;
  for (auto _ : state) found = extractor.Extract(image).size();
  state.counters["lines"] = static_cast<double>(found);
}

void Describe(benchmark::State& state, const Scene& scene) {
  const cv::Mat image = Load(scene, true);
  const auto lines = LineExtractor(LineOptions()).Extract(image);
  Gradients gradients;
  ComputeGradients(image, gradients);
  for (auto _ : state) {
    for (const LineFeature& l : lines) benchmark::DoNotOptimize(ComputeLbd(gradients, l.segment));
  }
  state.counters["lines"] = static_cast<double>(lines.size());
}

void MatchStereoPair(benchmark::State& state, const Scene& scene) {
  const cv::Mat left = Load(scene, true);
  const cv::Mat right = Load(scene, false);
  LineExtractor extractor{LineOptions()};
  const std::vector<StereoLine> lines = vo::WithoutDepth(extractor.Extract(left));
  const std::vector<LineFeature> right_lines = extractor.Extract(right);
  int with_depth = 0;
  for (auto _ : state) {
    std::vector<StereoLine> matched = lines;
    vo::MatchLinesStereo(matched, right_lines, left, right, vo::RowField(), StereoOptions());
    with_depth = 0;
    for (const StereoLine& l : matched) with_depth += l.HasDepth() ? 1 : 0;
  }
  state.counters["with_depth"] = with_depth;
}

void Project(benchmark::State& state, const Scene& scene) {
  LineExtractor extractor{LineOptions()};
  const auto features = extractor.Extract(Load(scene, true));
  std::vector<PredictedLine> predicted;
  for (const LineFeature& l : extractor.Extract(Load(scene, false))) predicted.push_back({l.segment, l.descriptor});
  for (auto _ : state) benchmark::DoNotOptimize(MatchLinesByProjection(predicted, features, LineMatchOptions()));
  state.counters["lines"] = static_cast<double>(predicted.size());
}

void Median(benchmark::internal::Benchmark* b) {
  b->Unit(benchmark::kMillisecond)->Repetitions(5)->ReportAggregatesOnly(true);
}

void RegisterScene(const Scene& scene) {
  const std::string suffix = std::string("/") + scene.name;
  for (const Choice<Segments>& choice : ChoicesOf(Segments())) {
    const Segments detector = choice.value;
    const std::string name = choice.name + suffix;
    Median(benchmark::RegisterBenchmark(("LineDetect/" + name).c_str(),
                                        [&scene, detector](auto& state) { Detect(state, scene, detector); }));
    Median(benchmark::RegisterBenchmark(("LineExtract/" + name).c_str(),
                                        [&scene, detector](auto& state) { Extract(state, scene, detector); }));
  }
  Median(benchmark::RegisterBenchmark(("LineDescribe" + suffix).c_str(),
                                      [&scene](auto& state) { Describe(state, scene); }));
  Median(benchmark::RegisterBenchmark(("LineStereo" + suffix).c_str(),
                                      [&scene](auto& state) { MatchStereoPair(state, scene); }));
  Median(benchmark::RegisterBenchmark(("LineProjection" + suffix).c_str(),
                                      [&scene](auto& state) { Project(state, scene); }));
}

}  // namespace
}  // namespace plslam

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  for (const plslam::Scene& scene : plslam::kScenes) plslam::RegisterScene(scene);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
