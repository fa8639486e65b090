// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/joint_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/errors/standard_streams.h"
#include "core/run/result_files.h"
#include "tools/evaluate/compare/run_paths.h"
#include "viewer_headless/report/report_page.h"

namespace plslam::evaluate {
namespace {

using Json = nlohmann::ordered_json;

/// As many colours as the page has for them.
constexpr size_t kMaxOthers = 6;

std::string ReportOf(const RunRecord& run) {
  const std::string path = run.folder + "/" + result_file::kReport;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": is missing; the map of a run is read from its report");
  return viewer::ReadPage(file);
}

Run PathsOf(const RunRecord& run) {
  std::optional<Run> paths = FindRunPaths(run.folder);
  if (!paths) {
    throw std::runtime_error(fmt::format("{}/{}: has no readable poses", run.folder, result_file::kTrajectory.tum));
  }
  return *std::move(paths);
}

std::string LastPart(const std::string& folder) {
  return std::filesystem::path(folder + "/").lexically_normal().parent_path().filename();
}

/// Returns the last part of the folder if it is unique among the runs.
std::string NameOf(const RunRecord& run, const std::vector<RunRecord>& runs) {
  const std::string name = LastPart(run.folder);
  const auto n = std::count_if(runs.begin(), runs.end(), [&](const auto& r) { return LastPart(r.folder) == name; });
  return n > 1 ? run.folder : name;
}

/// What others.js reads.
Json OtherRun(const RunRecord& run, const std::string& name, const SE3& T_base_w) {
  Json data = Json::parse(viewer::DataOfReport(ReportOf(run)));
  // The page shows neither of other runs, and they are most of the bytes.
  for (const char* list : {"processes", "pictures", "loops", "corrections"}) data.at(list) = Json::array();
  data["surfaces"] = nullptr;
  if (data.at("path").is_null() || data.at("map").is_null()) throw std::runtime_error("its report has no map");
  const Eigen::Matrix4d T = T_base_w.matrix();
  Json transform = Json::array();
  for (int i = 0; i < 16; ++i) transform.push_back(T(i / 4, i % 4));
  return {{"label", name}, {"transform", transform}, {"data", std::move(data)}};
}

}  // namespace

std::string JointMapPage(const std::vector<RunRecord>& runs, const std::string& comparison_link) {
  const RunRecord& base = runs.front();
  const Run base_paths = PathsOf(base);
  Json others = Json::array();
  for (size_t i = 1; i < runs.size() && others.size() < kMaxOthers; ++i) {
    if (runs[i].played != base.played) continue;
    try {
      others.push_back(OtherRun(runs[i], NameOf(runs[i], runs), BaseFromOther(base_paths, PathsOf(runs[i]))));
    } catch (const Json::exception&) {
      throw std::runtime_error(
          fmt::format("{}/{}: has no map, or is from another version", runs[i].folder, result_file::kReport));
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(fmt::format("{}: {}", runs[i].folder, error.what()));
    }
  }
  if (others.empty()) {
    throw std::runtime_error(
        fmt::format("no other run used the dataset of {}: there is no map to draw into its own", base.folder));
  }
  if (others.size() + 1 < runs.size()) {
    PrintError(fmt::format("the map shows {} of {} runs: those with the dataset of {}, at most {}", others.size() + 1,
                           runs.size(), base.folder, kMaxOthers + 1));
  }
  const Json json = {{"name", NameOf(base, runs)}, {"comparison", comparison_link}, {"others", others}};
  try {
    return viewer::FillOtherRuns(ReportOf(base), json.dump(-1, ' ', false, Json::error_handler_t::replace));
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(fmt::format("{}/{}: {}", base.folder, result_file::kReport, error.what()));
  }
}

}  // namespace plslam::evaluate
