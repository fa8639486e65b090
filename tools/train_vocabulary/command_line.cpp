// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/command_line.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/features/matching/hamming.h"
#include "core/process/choice_argument.h"
#include "plslam_version.h"
#include "tools/command_line/run_command_line.h"
#include "tools/train_vocabulary/left_features.h"
#include "tools/train_vocabulary/vocabulary_trainer.h"

namespace plslam::train_vocabulary {
namespace {

struct Arguments {
  FeatureType kind = FeatureType::kPoints;
  std::string out;
  std::vector<std::string> sources;
  int stride = 1;
  TrainingOptions training;
};

void AddOptions(CLI::App& app, Arguments& a) {
  AddChoice<FeatureType>(&app, "--kind", "points (ORB) or lines (LBD)", [&a](FeatureType kind) {
    a.kind = kind;
  })->required();
  app.add_option("--out", a.out, "file to write")->required();
  app.add_option("sources", a.sources, "folders of images, datasets, built-in worlds (synthetic:room)")->required();
  app.add_option("--stride", a.stride, "use every n-th image of each source")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  app.add_option("--branching", a.training.branching, "number of children of a node")
      ->check(CLI::Range(2, VocabularyLimits::kMaxBranching))
      ->capture_default_str();
  app.add_option("--depth", a.training.depth, "levels")
      ->check(CLI::Range(1, VocabularyLimits::kMaxDepth))
      ->capture_default_str();
  app.add_option("--min-descriptors", a.training.min_descriptors, "a node with fewer descriptors is not divided")
      ->check(CLI::Range(2, 1000000))
      ->capture_default_str();
  app.add_option("--seed", a.training.seed, "seed of the random numbers")->capture_default_str();
  app.set_version_flag("--version", PLSLAM_VERSION);
}

/// A line that is written over, on a terminal only.
void ShowProgress(const std::string& what, double share) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::fputs(fmt::format("\r\033[K{} {:3.0f} %{}", what, 100.0 * share, share < 1.0 ? "" : "\r\033[K").c_str(),
             stderr);
  std::fflush(stderr);
}

std::vector<std::vector<Descriptor>> ReadDescriptors(const Arguments& a) {
  FeatureOptions options;
  options.features = a.kind == FeatureType::kPoints ? FeatureTypes::kPoints : FeatureTypes::kLines;
  std::vector<std::vector<Descriptor>> images;
  for (const std::string& source : a.sources) {
    const size_t before = images.size();
    const auto use = [&](const ImageFeatures& f) {
      images.push_back(a.kind == FeatureType::kPoints ? DescriptorsOf(f.points) : DescriptorsOf(f.lines));
    };
    ForEachImageOf(source, a.stride, options, use, [&](int i, int n) { ShowProgress(source, 1.0 * i / n); });
    size_t descriptors = 0;
    for (size_t i = before; i < images.size(); ++i) descriptors += images[i].size();
    fmt::print("{:<60} {:5} images {:8} descriptors\n", source, images.size() - before, descriptors);
    std::fflush(stdout);
  }
  return images;
}

int Train(const Arguments& a) {
  const std::vector<std::vector<Descriptor>> images = ReadDescriptors(a);
  const Vocabulary vocabulary =
      TrainVocabulary(images, a.kind, a.training, [](double share) { ShowProgress("training", share); });
  if (vocabulary.words() < 2) throw std::runtime_error("these images have too few descriptors for a vocabulary");
  vocabulary.Save(a.out);
  fmt::print("{}: {} words from {} images, {} bytes, checksum {}\n", a.out, vocabulary.words(),
             vocabulary.tree().images, vocabulary.ToBytes().size(), vocabulary.checksum());
  return 0;
}

}  // namespace

int RunTrainVocabulary(int argc, char** argv) {
  CLI::App app(
      "Trains a visual vocabulary for place recognition. docs/lab/places.md has the commands for the default ones.",
      "train_vocabulary");
  Arguments arguments;
  AddOptions(app, arguments);
  app.footer(
      "Examples:\n"
      "  train_vocabulary --kind points --out my_orb.vocabulary /data/images synthetic:room\n"
      "  train_vocabulary --kind lines --out my_lbd.vocabulary --stride 5 /data/euroc/MH_01\n"
      "Exit code 0 if done; 1 if not, with one sentence on standard error.");
  return RunCommandLine(app, argc, argv, [&] { return Train(arguments); });
}

}  // namespace plslam::train_vocabulary
