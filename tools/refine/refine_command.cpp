// SPDX-License-Identifier: BSD-3-Clause
#include "tools/refine/refine_command.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "core/process/choice_argument.h"
#include "core/process/process_signals.h"
#include "tools/refine/refine_run.h"

namespace plslam::refine {
namespace {

struct RefineArguments {
  RefineRequest request;
  bool quiet = false;
};

/// A third of the memory that is free: Ceres has its Jacobian besides, and other programs run.
uint64_t MemoryForFactor() {
  const auto pages = static_cast<uint64_t>(sysconf(_SC_AVPHYS_PAGES));
  return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) / 3;
}

std::string ProgressText(const RefineProgress& progress) {
  std::string text =
      fmt::format("pass {}, iteration {}, cost {:.1f}", progress.pass, progress.iteration, progress.cost);
  const double left_s = std::ceil(progress.remaining_s);
  if (left_s <= 0.0) return text;
  return left_s < 120.0 ? fmt::format("{}, about {:.0f} s left", text, left_s)
                        : fmt::format("{}, about {:.0f} min left", text, std::ceil(left_s / 60.0));
}

int Refine(const RefineArguments& arguments) {
  std::atomic<bool> stop = false;
  const bus::SignalWatcher signals([&stop](const std::string&) { stop = true; });
  RefineRequest request = arguments.request;
  request.options.stop = &stop;
  request.options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  request.options.memory_bytes = MemoryForFactor();
  const bool redraws = !arguments.quiet && isatty(STDERR_FILENO) == 1;
  if (!arguments.quiet) {
    request.options.announce = [](const std::string& sentence) { fmt::print("{}\n", sentence); };
  }
  if (redraws) {
    request.options.progress = [](const RefineProgress& progress) {
      fmt::print(stderr, "\r{}\x1b[K", ProgressText(progress));
      std::fflush(stderr);
    };
  }
  const RefinedRun run = RefineRun(request);
  if (redraws) fmt::print(stderr, "\r\x1b[K");
  if (!arguments.quiet) fmt::print("{}the refined map is in {}\n", run.table, request.out);
  return 0;
}

}  // namespace

void AddRefineCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<RefineArguments>();
  auto* sub = app->add_subcommand("refine", "adjusts a saved map as a whole: the best map that its features allow");
  sub->add_option("source", arguments->request.source,
                  "map file (.plmap), or folder of a run that contains one (plslam run --save-map)")
      ->required();
  sub->add_option("--out", arguments->request.out, "folder for the new map, its trajectory and a summary")
      ->type_name("DIR")
      ->required();
  AddChoice(sub, "--camera", arguments->request.options.camera,
            "estimate of the camera: fixed, intrinsics (focal length, principal point and radial distortion), or all "
            "(focal length, principal point, and the right camera relative to the left one)");
  sub->add_flag("--quiet", arguments->quiet, "print nothing");
  sub->footer(
      "Examples:\n"
      "  plslam refine out/room --out out/room_refined\n"
      "  plslam refine out/house.plmap --out out/house_refined --camera all\n"
      "SIGINT (Ctrl-C) ends it with the best map so far.");
  sub->callback([=] { *command = [arguments] { return Refine(*arguments); }; });
}

}  // namespace plslam::refine
