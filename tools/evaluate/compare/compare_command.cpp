// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/evaluate_commands.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <exception>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>

#include "core/errors/standard_streams.h"
#include "core/files/atomic_file.h"
#include "core/io/trajectories/trajectory.h"
#include "core/process/choice_argument.h"
#include "core/run/result_files.h"
#include "tools/command_line/run_command_line.h"
#include "tools/evaluate/compare/comparison_page.h"
#include "tools/evaluate/compare/comparison_text.h"
#include "tools/evaluate/compare/joint_map.h"

namespace plslam::evaluate {
namespace {

namespace fs = std::filesystem;

/// Output: a table, or converted trajectories.
enum class Output { kText, kMarkdown, kLatex, kCsv, kJson, kTum, kKitti };
constexpr auto ChoicesOf(Output) {
  return std::array{Choice{"text", Output::kText},   Choice{"markdown", Output::kMarkdown},
                    Choice{"latex", Output::kLatex}, Choice{"csv", Output::kCsv},
                    Choice{"json", Output::kJson},   Choice{"tum", Output::kTum},
                    Choice{"kitti", Output::kKitti}};
}

struct Arguments {
  std::vector<std::string> runs;
  Output format = Output::kText;
  std::string out;
  std::string html;
  std::string map;
};

void AddOptions(CLI::App& app, Arguments& a) {
  app.add_option("runs", a.runs, "folders of runs, or folders that contain such folders; other files are skipped")
      ->required();
  AddChoice(&app, "--format", a.format,
            "output format: text, markdown, latex, csv, json; tum or kitti: converted trajectories, in --out");
  app.add_option("--out", a.out, "write to this file instead (tum and kitti: folder)");
  app.add_option("--html", a.html, "also write a page with tables and plots")->type_name("FILE");
  app.add_option("--map", a.map,
                 "also write the report of the first run with the paths and landmarks of the others in its map")
      ->type_name("FILE");
}

/// The arguments, sorted into runs and others.
struct Named {
  std::vector<RunRecord> runs;
  std::vector<std::string> others;  ///< exist, but are no runs
};

void AddRun(const std::string& folder, Named* named) {
  std::optional<RunRecord> run = FindRunRecord(folder);
  if (run) {
    named->runs.push_back(*std::move(run));
  } else {
    named->others.push_back(folder);
  }
}

/// A folder without a summary means the runs in it.
void AddNamed(const std::string& name, Named* named) {
  if (!fs::exists(name)) throw std::runtime_error(name + ": does not exist");
  if (!fs::is_directory(name) || fs::exists(fs::path(name) / result_file::kSummary)) return AddRun(name, named);
  std::vector<std::string> within;
  for (const auto& entry : fs::directory_iterator(name)) within.push_back(entry.path());
  std::sort(within.begin(), within.end());
  Named found;
  for (const std::string& path : within) AddRun(path, &found);
  if (found.runs.empty()) found.others = {name};
  named->runs.insert(named->runs.end(), found.runs.begin(), found.runs.end());
  named->others.insert(named->others.end(), found.others.begin(), found.others.end());
}

std::string NamesText(const std::vector<std::string>& names) {
  constexpr size_t kShown = 6;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kShown); ++i) text += (i == 0 ? "" : ", ") + names[i];
  return names.size() > kShown ? fmt::format("{} and {} more", text, names.size() - kShown) : text;
}

/// Throws std::runtime_error if there is no run.
std::vector<RunRecord> RunsOf(const std::vector<std::string>& names) {
  Named named;
  for (const std::string& name : names) AddNamed(name, &named);
  if (named.runs.empty()) {
    throw std::runtime_error(
        fmt::format("no run to compare (no folder with a {}): {}", result_file::kSummary, NamesText(named.others)));
  }
  if (!named.others.empty()) {
    PrintError(fmt::format("skipped {} that {}: {}", named.others.size(),
                           named.others.size() == 1 ? "is not a run" : "are not runs", NamesText(named.others)));
  }
  ResolveRecordings(&named.runs);
  return named.runs;
}

/// Returns file names for the runs: the folder's, numbered if two are the same.
std::vector<std::string> FileNames(const std::vector<RunRecord>& runs) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const RunRecord& run : runs) {
    const fs::path path = fs::path(run.folder + "/").lexically_normal().parent_path();
    std::string name = path.filename();
    for (int n = 2; !taken.insert(name).second; ++n) name = fmt::format("{}_{}", path.filename().string(), n);
    names.push_back(name);
  }
  return names;
}

void ConvertTrajectories(const std::vector<RunRecord>& runs, const Arguments& a) {
  const char* const name = NameOf(a.format);
  if (a.out.empty()) throw std::runtime_error(fmt::format("--format {} needs --out, the folder to write to", name));
  const TrajectoryFormat format = a.format == Output::kTum ? TrajectoryFormat::kTum : TrajectoryFormat::kKitti;
  fs::create_directories(a.out);
  const std::vector<std::string> names = FileNames(runs);
  for (size_t i = 0; i < runs.size(); ++i) {
    const std::string file = fmt::format("{}/{}.{}", a.out, names[i], name);
    const Trajectory trajectory =
        ReadTrajectory(fmt::format("{}/{}", runs[i].folder, result_file::kTrajectory.tum), TrajectoryFormat::kTum);
    WriteTrajectory(file, format, trajectory);
    fmt::print("{}: {} poses\n", file, trajectory.size());
  }
}

std::string Formatted(const std::vector<RunGroup>& groups, Output format) {
  if (format == Output::kMarkdown) return ComparisonMarkdown(groups);
  if (format == Output::kLatex) return ComparisonLatex(groups);
  if (format == Output::kCsv) return ComparisonCsv(groups);
  if (format == Output::kJson) return ComparisonJson(groups).dump(2) + "\n";
  return ComparisonText(groups);
}

/// The address of the file `to` for a page at `from`: relative, so that both can move together, and escaped.
std::string LinkTo(const std::string& to, const std::string& from) {
  const fs::path folder = fs::absolute(from).lexically_normal().parent_path();
  std::string link;
  for (const char c : fs::absolute(to).lexically_normal().lexically_relative(folder).generic_string()) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 ||
                       std::string_view("/._-~").find(c) != std::string_view::npos;
    link += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return link;
}

/// The page of --html links to that of --map, and back. A run without report.html prevents only the map, and then there
/// is no link.
void WritePages(const Arguments& a, const std::vector<RunRecord>& runs, const std::vector<RunGroup>& groups) {
  const bool both = !a.html.empty() && !a.map.empty();
  std::exception_ptr no_map;
  try {
    if (!a.map.empty()) WriteFileAtomically(a.map, JointMapPage(runs, both ? LinkTo(a.html, a.map) : ""));
  } catch (const std::runtime_error&) {
    no_map = std::current_exception();
  }
  if (!a.html.empty()) {
    WriteFileAtomically(a.html, ComparisonPage(groups, both && !no_map ? LinkTo(a.map, a.html) : ""));
  }
  if (no_map) std::rethrow_exception(no_map);
}

int CompareRuns(const Arguments& a) {
  const std::vector<RunRecord> runs = RunsOf(a.runs);
  std::set<fs::path> folders;
  for (const RunRecord& run : runs) {
    if (folders.insert(fs::weakly_canonical(run.folder)).second) continue;
    throw std::runtime_error(fmt::format("{}: is given twice; a run counts once", run.folder));
  }
  const bool converts = a.format == Output::kTum || a.format == Output::kKitti;
  if (converts) ConvertTrajectories(runs, a);
  const std::vector<RunGroup> groups = Compare(runs);
  const std::string text = converts ? "" : Formatted(groups, a.format);
  if (a.out.empty()) {
    fmt::print("{}", text);
  } else if (!converts) {
    WriteFileAtomically(a.out, text);
  }
  WritePages(a, runs, groups);
  return 0;
}

}  // namespace

int RunEvaluateCompare(int argc, char** argv) {
  CLI::App app(
      "Compares several runs: median, worst and spread by dataset and configuration. docs/metrics.md "
      "defines the numbers.",
      "evaluate compare");
  Arguments arguments;
  AddOptions(app, arguments);
  app.footer(
      "Examples:\n  evaluate compare out/room_points out/room_lines out/room_both --html compare.html\n"
      "  evaluate compare out/room_points out/room_both --html compare.html --map both_maps.html\n"
      "  evaluate compare out --format markdown");
  return RunCommandLine(app, argc, argv, [&] { return CompareRuns(arguments); });
}

}  // namespace plslam::evaluate
