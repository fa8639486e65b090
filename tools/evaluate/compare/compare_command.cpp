#include "tools/evaluate/compare/compare_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "core/io/files/atomic_file.h"
#include "core/io/trajectories/trajectory.h"
#include "tools/command_line/run_command_line.h"
#include "tools/evaluate/compare/comparison_page.h"
#include "tools/evaluate/compare/comparison_text.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

struct Arguments {
  std::vector<std::string> runs;
  std::string format = "text";
  std::string out;
  std::string html;
};

void AddOptions(CLI::App& app, Arguments& a) {
  app.add_option("runs", a.runs, "folders of runs; or folders of such folders, for all in them")->required();
  app.add_option(
         "--format", a.format,
         "what is printed: text, markdown, latex, csv, json; or trajectories converted to tum or kitti, in --out")
      ->check(CLI::IsMember({"text", "markdown", "latex", "csv", "json", "tum", "kitti"}))
      ->capture_default_str();
  app.add_option("--out", a.out, "write to this file instead (tum and kitti: folder)");
  app.add_option("--html", a.html, "also write a page with tables and plots")->type_name("FILE");
}

/// A folder without a summary stands for the runs in it.
std::vector<std::string> FoldersOf(const std::vector<std::string>& named) {
  std::vector<std::string> folders;
  for (const std::string& name : named) {
    std::vector<std::string> within;
    if (fs::is_directory(name) && !fs::exists(name + "/summary.json")) {
      for (const auto& entry : fs::directory_iterator(name)) {
        if (fs::exists(entry.path() / "summary.json")) within.push_back(entry.path());
      }
    }
    std::sort(within.begin(), within.end());
    if (within.empty()) within.push_back(name);
    folders.insert(folders.end(), within.begin(), within.end());
  }
  return folders;
}

/// Names of files for the runs: the folder's, numbered where two are the same.
std::vector<std::string> FileNames(const std::vector<std::string>& folders) {
  std::vector<std::string> names;
  std::set<std::string> taken;
  for (const std::string& folder : folders) {
    const fs::path path = fs::path(folder + "/").lexically_normal().parent_path();
    std::string name = path.filename();
    for (int n = 2; !taken.insert(name).second; ++n) name = fmt::format("{}_{}", path.filename().string(), n);
    names.push_back(name);
  }
  return names;
}

void ConvertTrajectories(const std::vector<std::string>& folders, const Arguments& a) {
  if (a.out.empty()) throw std::runtime_error("--format " + a.format + " needs --out, the folder to write to");
  fs::create_directories(a.out);
  const std::vector<std::string> names = FileNames(folders);
  for (size_t i = 0; i < folders.size(); ++i) {
    const std::string file = fmt::format("{}/{}.{}", a.out, names[i], a.format);
    const Trajectory trajectory = ReadTrajectory(folders[i] + "/trajectory.tum", TrajectoryFormat::kTum);
    WriteTrajectory(file, TrajectoryFormatFromName(a.format), trajectory);
    fmt::print("{}: {} poses\n", file, trajectory.size());
  }
}

std::string Formatted(const std::vector<RunGroup>& groups, const std::string& format) {
  if (format == "markdown") return ComparisonMarkdown(groups);
  if (format == "latex") return ComparisonLatex(groups);
  if (format == "csv") return ComparisonCsv(groups);
  if (format == "json") return ComparisonJson(groups).dump(2) + "\n";
  return ComparisonText(groups);
}

int CompareRuns(const Arguments& a) {
  const std::vector<std::string> folders = FoldersOf(a.runs);
  if (a.format == "tum" || a.format == "kitti") {
    ConvertTrajectories(folders, a);
    if (a.html.empty()) return 0;
  }
  std::vector<RunRecord> runs;
  runs.reserve(folders.size());
  for (const std::string& folder : folders) runs.push_back(ReadRunRecord(folder));
  const std::vector<RunGroup> groups = Compare(runs);
  if (!a.html.empty()) WriteFileAtomically(a.html, ComparisonPage(groups));
  if (a.format == "tum" || a.format == "kitti") return 0;
  const std::string text = Formatted(groups, a.format);
  if (a.out.empty()) {
    fmt::print("{}", text);
  } else {
    WriteFileAtomically(a.out, text);
  }
  return 0;
}

}  // namespace

int RunEvaluateCompare(int argc, char** argv) {
  CLI::App app(
      "Several runs side by side: medians, worst and spread by dataset and configuration. docs/metrics.md "
      "defines the numbers.",
      "evaluate compare");
  Arguments arguments;
  AddOptions(app, arguments);
  app.footer(
      "Examples:\n  evaluate compare out/room_points out/room_lines out/room_both --html compare.html\n"
      "  evaluate compare out --format markdown");
  return RunCommandLine(app, argc, argv, [&] { return CompareRuns(arguments); });
}

}  // namespace plslam
