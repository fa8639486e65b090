// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/command_line.h"

#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "core/io/maps/map_file.h"
#include "core/process/choice_argument.h"
#include "tools/command_line/run_command_line.h"
#include "tools/pose_graph/export.h"
#include "tools/pose_graph/solve.h"

namespace plslam::pose_graph {
namespace {

struct Arguments {
  std::string file;
  std::string map;
  std::string out;
  std::string tum;
  bool json = false;
  SolveOptions solve;
};

void Declare(CLI::App& app, Arguments& a) {
  auto* file = app.add_option("FILE", a.file, "pose graph in g2o format, 2D or 3D");
  app.add_option("--from-map", a.map, "write the pose graph of this map file unchanged, instead of solving one")
      ->excludes(file);
  AddChoice(&app, "--initial", a.solve.initial,
            "initial poses: those of the file, chained odometry, or chordal relaxation");
  AddChoice(&app, "--start", a.solve.graph.start,
            "given: start from these only; chordal: from chordal relaxation; best: from both");
  app.add_option("--perturb", a.solve.perturb, "noise added to the initial poses, m and rad")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--seed", a.solve.seed, "seed of the noise")->capture_default_str();
  app.add_option("--max-iterations", a.solve.graph.max_iterations, "most steps of the solver")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  auto* reject = app.add_option("--reject", a.solve.graph.rejection_chi2,
                                "remove edges, except odometry, that contradict the rest by this chi-square [none]");
  reject->check(CLI::Range(1.0, 1e12));
  app.add_option("--out", a.out, "write the solved graph (g2o)");
  app.add_option("--tum", a.tum,
                 "write the poses (TUM; vertex numbers as times, in seconds; for a map, one file per session)");
  app.add_flag("--json", a.json, "print the report as JSON");
  app.callback([&a, reject] {
    a.solve.reject = reject->count() > 0;
    if (a.file.empty() && a.map.empty()) throw CLI::RequiredError("FILE or --from-map");
  });
}

void Print(const Arguments& a, const SolveReport& report) {
  if (a.json) {
    const nlohmann::ordered_json json = {{"file", a.file},
                                         {"initial", a.solve.initial},
                                         {"poses", report.poses},
                                         {"edges", report.edges},
                                         {"chi2_before", report.chi2_before},
                                         {"chi2_after", report.chi2_after},
                                         {"rejected_edges", report.rejected},
                                         {"iterations", report.iterations},
                                         {"seconds", report.seconds}};
    fmt::print("{}\n", json.dump(2));
    return;
  }
  fmt::print("{}: {} poses, {} edges\n", a.file, report.poses, report.edges);
  fmt::print("chi2 {:.9g} -> {:.9g}, {} iterations, {:.3f} s\n", report.chi2_before, report.chi2_after,
             report.iterations, report.seconds);
  if (a.solve.reject) fmt::print("{} edges rejected\n", report.rejected);
}

void Solve(const Arguments& a) {
  G2oFile file = ReadG2o(a.file);
  const SolveReport report = SolveG2o(file, a.solve);
  if (!report.ok) throw std::runtime_error(a.file + ": " + report.reason);
  std::visit(
      [&](const auto& graph) {
        if (!a.out.empty()) WriteG2o(a.out, graph);
        if (!a.tum.empty()) WriteTrajectory(a.tum, TrajectoryFormat::kTum, TrajectoryOf(graph));
      },
      file.content);
  Print(a, report);
}

/// POSES.tum, and POSES_sN.tum for each further session.
void WriteSessions(const std::filesystem::path& file, const Map& map) {
  const std::vector<SessionTrajectory> sessions = TrajectoriesOf(map);
  if (sessions.empty()) WriteTrajectory(file.string(), TrajectoryFormat::kTum, {});
  for (const auto& [suffix, keyframes] : sessions) {
    const std::string name = file.stem().string() + suffix + file.extension().string();
    WriteTrajectory((file.parent_path() / name).string(), TrajectoryFormat::kTum, keyframes);
  }
}

void Export(const Arguments& a) {
  const StoredMap stored = ReadMapFile(a.map);
  const G2oGraph<SE3> graph = G2oOf(stored.map);
  if (!a.out.empty()) WriteG2o(a.out, graph);
  if (!a.tum.empty()) WriteSessions(a.tum, stored.map);
  fmt::print("{}: {} keyframes, {} edges, {} of them loops\n", a.map, graph.graph.poses.size(),
             graph.graph.edges.size(), stored.map.loops().size());
}

}  // namespace

int RunPoseGraph(int argc, char** argv) {
  CLI::App app("Solves 2D and 3D pose graphs by least squares.", "pose_graph");
  Arguments arguments;
  Declare(app, arguments);
  app.footer(
      "Examples:\n"
      "  pose_graph sphere2500.g2o --out solved.g2o --tum solved.tum\n"
      "  pose_graph --from-map house.plmap --out house.g2o\n"
      "Exit code 0 if a minimum was found; 1 if not, with one sentence on standard error.");
  return RunCommandLine(app, argc, argv, [&] {
    if (arguments.map.empty()) {
      Solve(arguments);
    } else {
      Export(arguments);
    }
    return 0;
  });
}

}  // namespace plslam::pose_graph
