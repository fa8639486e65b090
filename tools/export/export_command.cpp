// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/export_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "tools/export/export_run.h"

namespace plslam::exports {
namespace {

struct ExportArguments {
  ExportRequest request;
  bool quiet = false;
  bool json = false;
};

/// In the folder of the run, or beside the map and named after it.
std::string DefaultOut(const std::string& source) {
  const std::filesystem::path path(source);
  if (std::filesystem::is_directory(path)) return (path / "export").string();
  return (path.parent_path() / (path.stem().string() + "_export")).string();
}

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  for (const ExportFormat& format : ExportFormats()) names.push_back(format.name);
  return names;
}

std::string Footer() {
  std::string text = "Formats:\n";
  for (const ExportFormat& format : ExportFormats()) {
    text += fmt::format("  {:<12} {}\n", format.name, format.what);
  }
  return text +
         "Examples:\n"
         "  plslam export out/house.plmap\n"
         "  plslam export out/room --format ply obj --out room_for_meshlab\n"
         "  plslam export out/mh01.plmap --dataset /data/euroc/MH_01 --format colmap\n"
         "  plslam export out/walk.lcm --format mcap";
}

void Print(const std::vector<ExportedFile>& files, const ExportArguments& arguments) {
  if (arguments.json) {
    nlohmann::json json = nlohmann::json::array();
    for (const ExportedFile& file : files) json.push_back({{"path", file.path}, {"what", file.what}});
    fmt::print("{}\n", json.dump(2));
  } else if (!arguments.quiet) {
    for (const ExportedFile& file : files) fmt::print("{}: {}\n", file.path, file.what);
  }
}

int Export(const ExportArguments& arguments) {
  ExportRequest request = arguments.request;
  if (request.out.empty()) request.out = DefaultOut(request.source);
  Print(ExportRun(request), arguments);
  return 0;
}

}  // namespace

void AddExportCommand(CLI::App* app, std::function<int()>* command) {
  auto arguments = std::make_shared<ExportArguments>();
  auto* sub =
      app->add_subcommand("export", "exports a saved map, a run or a recorded log to files for other programs");
  sub->add_option("source", arguments->request.source,
                  "map file (.plmap), folder of a run that contains one, or LCM log of a run (plslam run --record)")
      ->required();
  sub->add_option("--out", arguments->request.out, "folder to write to [RUN/export or MAP_export]")->type_name("DIR");
  sub->add_option("--format", arguments->request.formats, "only these formats, separated by blanks or commas [all]")
      ->delimiter(',')
      ->check(CLI::IsMember(FormatNames()));
  sub->add_option("--dataset", arguments->request.dataset,
                  "dataset of the map, for rectified images of the keyframes (COLMAP) and poses of the camera as "
                  "calibrated");
  sub->add_flag("--quiet", arguments->quiet, "print nothing");
  sub->add_flag("--json", arguments->json, "print the list of files as JSON");
  sub->footer(Footer());
  sub->callback([=] { *command = [arguments] { return Export(*arguments); }; });
}

}  // namespace plslam::exports
