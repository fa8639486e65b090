// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/evaluate_commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cctype>
#include <filesystem>
#include <stdexcept>

#include "core/datasets/open_dataset.h"
#include "core/files/atomic_file.h"
#include "core/files/shared_file.h"
#include "tools/command_line/run_command_line.h"
#include "tools/evaluate/places/place_report.h"
#include "tools/train_vocabulary/left_features.h"

namespace plslam::evaluate {
namespace {

struct Arguments {
  std::vector<std::string> datasets;
  std::string points = "orb.vocabulary";
  std::string lines = "lbd.vocabulary";
  std::string out;
  std::string json;
  int stride = 1;
  RevisitOptions revisit;
};

void AddOptions(CLI::App& app, Arguments& a) {
  app.add_option("datasets", a.datasets, "sequences with true poses (folders, logs, built-in worlds)")->required();
  app.add_option("--points", a.points, "vocabulary of points: a path, or a file installed with the programs")
      ->capture_default_str();
  app.add_option("--lines", a.lines, "vocabulary of lines, likewise")->capture_default_str();
  app.add_option("--stride", a.stride, "play every n-th frame")->check(CLI::Range(1, 1000000))->capture_default_str();
  app.add_option("--distance", a.revisit.distance_m, "largest distance of a revisit, in metres")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--angle", a.revisit.angle_deg, "largest angle of a revisit, in degrees")
      ->check(CLI::Range(0.0, 180.0))
      ->capture_default_str();
  app.add_option("--far-distance", a.revisit.far_distance_m,
                 "distance above which two frames are at different places, in metres")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--far-angle", a.revisit.far_angle_deg,
                 "angle above which two frames show different places, in degrees")
      ->check(CLI::Range(0.0, 180.0))
      ->capture_default_str();
  app.add_option("--min-gap", a.revisit.min_gap_s, "pairs closer in time are ignored, in seconds")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--out", a.out, "folder for pictures: similarity matrices, precision and recall (PNG)");
  app.add_option("--json", a.json, "write all numbers to this file");
}

std::vector<PlaceFrame> ReadFrames(const std::string& location, int stride, const PlaceRecogniser& recogniser) {
  const auto dataset = OpenDatasetAndWarn(location, "");
  std::vector<PlaceFrame> frames;
  const auto use = [&](int index, const ImageFeatures& features) {
    const auto T_w_c = dataset->GroundTruth(index);
    if (T_w_c) frames.push_back({{dataset->t_ns(index), *T_w_c}, recogniser.Describe(features)});
  };
  train_vocabulary::ForEachLeftImage(*dataset, stride, FeatureOptions{}, use, [](int, int) {});
  if (frames.empty()) throw std::runtime_error(location + " has no true poses");
  return frames;
}

/// Returns the last part of a dataset's name without characters that are unusual in file names.
std::string FileName(const std::string& location) {
  std::string name = std::filesystem::path(location).lexically_normal().filename();
  if (name.empty()) name = std::filesystem::path(location).lexically_normal().parent_path().filename();
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-' ? c : '_';
  return name;
}

void WritePictures(const PlaceEvaluation& evaluation, const std::string& folder) {
  std::filesystem::create_directories(folder);
  const std::string start = (std::filesystem::path(folder) / FileName(evaluation.name)).string();
  WriteDrawing(start + "_similarity.png", SimilarityFigure(evaluation.name, evaluation.similarities, "frames"));
  WriteDrawing(start + "_precision_recall.png", PrecisionRecallFigure(evaluation));
}

int Evaluate(const Arguments& a) {
  const Vocabulary points = Vocabulary::Load(FindSharedFile(a.points));
  const PlaceRecogniser recogniser(points, Vocabulary::Load(FindSharedFile(a.lines)), PlaceOptions{});
  std::vector<PlaceEvaluation> evaluations;
  for (const std::string& dataset : a.datasets) {
    evaluations.push_back(EvaluatePlaces(dataset, ReadFrames(dataset, a.stride, recogniser), points,
                                         recogniser.line_vocabulary(), a.revisit));
    fmt::print("{}\n", PlaceTable(evaluations.back()));
    std::fflush(stdout);
    if (!a.out.empty()) WritePictures(evaluations.back(), a.out);
  }
  if (!a.json.empty()) WriteFileAtomically(a.json, PlacesToJson(evaluations, a.revisit).dump(2) + "\n");
  return 0;
}

}  // namespace

int RunEvaluatePlaces(int argc, char** argv) {
  CLI::App app("Evaluates place recognition by points, by lines and by both. docs/lab/places.md defines the numbers.",
               "evaluate places");
  Arguments arguments;
  AddOptions(app, arguments);
  return RunCommandLine(app, argc, argv, [&] { return Evaluate(arguments); });
}

}  // namespace plslam::evaluate
