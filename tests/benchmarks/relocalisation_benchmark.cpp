// SPDX-License-Identifier: BSD-3-Clause
// Time until a camera is relocalised that was moved while its lens was covered: a row for each world.
//
//   relocalisation_benchmark [WORLD...] [--trials N] [--carried METRES]

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <opencv2/core/utility.hpp>

#include "core/datasets/open_dataset.h"
#include "loop_process/loop_service.h"
#include "tests/support/relocalisation_run.h"
#include "tools/command_line/run_command_line.h"

namespace {

using plslam::test::RelocalisationTrial;

struct Counts {
  int trials = 0;
  int soon = 0;
  int wrong = 0;
};

Counts PrintTrials(const std::string& world, const std::vector<RelocalisationTrial>& results, int second) {
  Counts counts;
  int slowest = 0;
  for (const RelocalisationTrial& trial : results) {
    const bool found = trial.frames_until_right > 0 && trial.frames_until_right <= second;
    counts.soon += found ? 1 : 0;
    counts.wrong += trial.wrong_before + trial.wrong_afterwards > 0 ? 1 : 0;
    slowest = std::max(slowest, trial.frames_until_right);
    if (found) continue;
    std::printf("  frame %d (%.1f m away): asked %d, answered %d, wrongly %d, poses wrong before %d, after %d\n",
                trial.to_frame, trial.carried_m, trial.asked, trial.answered, trial.answered_wrongly,
                trial.wrong_before, trial.wrong_afterwards);
  }
  counts.trials = static_cast<int>(results.size());
  std::printf("%-60s within a second %d of %d, slowest %d frames, wrong poses in %d\n", world.c_str(), counts.soon,
              counts.trials, slowest, counts.wrong);
  std::fflush(stdout);
  return counts;
}

std::vector<std::string> DefaultWorlds() {
  std::vector<std::string> worlds;
  for (const char* seed : {"1", "2"}) {
    for (const char* world : {"room?size=376x240&speed=1.5", "street?size=376x240&speed=12"}) {
      worlds.push_back(std::string("synthetic:") + world + "&seed=" + seed);
    }
  }
  return worlds;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> worlds = DefaultWorlds();
  int n_trials = 10;
  plslam::test::RelocalisationTrials trials;
  CLI::App app("Relocalisation after the camera was carried with its lens covered", "relocalisation_benchmark");
  app.add_option("worlds", worlds, "datasets with truth");
  app.add_option("--trials", n_trials, "for each world");
  app.add_option("--carried", trials.min_carried_m, "metres at least");
  return plslam::RunCommandLine(app, argc, argv, [&] {
    cv::setNumThreads(1);
    const plslam::loop::LoopOptions loops;
    const plslam::PlaceRecogniser places = plslam::loop::LoadPlaces(loops.vocabularies, loops.places);
    Counts all;
    for (const std::string& world : worlds) {
      const auto dataset = plslam::OpenDataset(world, "");
      const auto second =
          static_cast<int>(std::lround(1e9 / static_cast<double>(dataset->t_ns(1) - dataset->t_ns(0))));
      const Counts counts = PrintTrials(
          world, plslam::test::RunRelocalisationTrials(*dataset, places, {}, {}, loops, trials, n_trials, 1), second);
      all.trials += counts.trials;
      all.soon += counts.soon;
      all.wrong += counts.wrong;
    }
    std::printf("all: within a second %d of %d, wrong poses in %d\n", all.soon, all.trials, all.wrong);
    return 0;
  });
}
