// How soon a camera is found again that was carried elsewhere while its lens was covered: a row for each world.
//
//   relocalisation_benchmark [WORLD...] [--trials N] [--carried METRES]

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "loop_process/vocabulary_files.h"
#include "player/open_dataset.h"
#include "tests/support/relocalisation_run.h"

int main(int argc, char** argv) {
  using plslam::test::RelocalisationTrial;
  cv::setNumThreads(1);
  std::vector<std::string> worlds;
  int n_trials = 10;
  plslam::test::RelocalisationTrials trials;
  CLI::App app("Relocalisation after the camera was carried with its lens covered");
  app.add_option("worlds", worlds, "datasets with truth");
  app.add_option("--trials", n_trials, "for each world");
  app.add_option("--carried", trials.min_carried_m, "metres at least");
  CLI11_PARSE(app, argc, argv);
  if (worlds.empty()) {
    for (const char* seed : {"1", "2"}) {
      for (const char* world : {"room", "street"}) {
        worlds.push_back(std::string("synthetic:") + world +
                         "?size=376x240&speed=" + (std::string(world) == "room" ? "1.5" : "12") + "&seed=" + seed);
      }
    }
  }
  const plslam::LoopOptions loops;
  const plslam::PlaceRecogniser places = plslam::LoadPlaces(loops.vocabularies, loops.places);
  int n_all = 0;
  int n_soon = 0;
  int n_wrong = 0;
  for (const std::string& world : worlds) {
    const auto dataset = plslam::OpenDataset(world, "");
    const int second = static_cast<int>(1e9 / static_cast<double>(dataset->t_ns(1) - dataset->t_ns(0)) + 0.5);
    const auto results = plslam::test::RunRelocalisationTrials(*dataset, places, {}, {}, loops, trials, n_trials, 1);
    int soon = 0;
    int wrong = 0;
    int slowest = 0;
    for (const RelocalisationTrial& trial : results) {
      const bool found = trial.frames_until_right > 0 && trial.frames_until_right <= second;
      soon += found ? 1 : 0;
      wrong += trial.wrong_before + trial.wrong_afterwards > 0 ? 1 : 0;
      slowest = std::max(slowest, trial.frames_until_right);
      if (!found) {
        std::printf("  frame %d (%.1f m away): asked %d, answered %d, wrongly %d, poses wrong before %d, after %d\n",
                    trial.to_frame, trial.carried_m, trial.asked, trial.answered, trial.answered_wrongly,
                    trial.wrong_before, trial.wrong_afterwards);
      }
    }
    std::printf("%-60s within a second %d of %zu, slowest %d frames, wrong poses in %d\n", world.c_str(), soon,
                results.size(), slowest, wrong);
    std::fflush(stdout);
    n_all += static_cast<int>(results.size());
    n_soon += soon;
    n_wrong += wrong;
  }
  std::printf("all: within a second %d of %d, wrong poses in %d\n", n_soon, n_all, n_wrong);
  return 0;
}
