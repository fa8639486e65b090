// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_files.h"

#include <cctype>
#include <cmath>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/files/atomic_file.h"
#include "core/run/result_files.h"
#include "tools/evaluate/accuracy.h"
#include "tools/plslam/process_table.h"
#include "viewer_headless/report/report_page.h"

namespace plslam::launcher {
namespace {

using std::filesystem::path;

/// Returns the outermost missing folder on the path to this one; empty if this one exists.
path FirstMissing(const path& folder) {
  path missing;
  std::error_code ignored;
  for (path each = folder; !std::filesystem::exists(each, ignored); each = each.parent_path()) missing = each;
  return missing;
}

path Absolute(const path& folder) {
  const path absolute = std::filesystem::absolute(folder).lexically_normal();
  return absolute.has_filename() ? absolute : absolute.parent_path();  // without a slash at its end
}

}  // namespace

OutputFolder::OutputFolder(const path& folder)
    : folder_(Absolute(folder)), first_made_(FirstMissing(folder_ / "logs")) {
  try {
    MakeFolder(folder.string());
    lock_.emplace(folder.string());
    MakeFolder((folder / "logs").string());
  } catch (const std::exception&) {
    Remove();
    throw;
  }
}

OutputFolder::~OutputFolder() {
  if (!kept_) Remove();
}

bool OutputFolder::has_results() const { return std::filesystem::exists(folder_ / result_file::kSummary); }

void OutputFolder::Remove() const {
  if (!lock_) return;
  std::error_code ignored;
  for (const ProcessRow& row : ProcessTable()) {
    std::filesystem::remove(folder_ / "logs" / (std::string(row.name) + ".log"), ignored);
  }
  if (first_made_.empty()) return;
  // Only empty folders are removed.
  for (path each = folder_ / "logs"; each != first_made_.parent_path(); each = each.parent_path()) {
    std::filesystem::remove(each, ignored);
  }
}

namespace {

/// FNV-1a, which stays the same from machine to machine.
uint32_t Hash(const std::string& text) {
  uint32_t hash = 2166136261U;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  return hash;
}

}  // namespace

std::filesystem::path DefaultOut(const std::string& dataset) {
  constexpr size_t kLongestName = 80;
  const std::string location = std::filesystem::path(dataset).lexically_normal().string();
  std::string name;
  for (const char c : location) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
    if (plain || (!name.empty() && name.back() != '_')) name += plain ? c : '_';
  }
  const size_t root = location.starts_with('/') ? 1 : 0;
  const bool whole = root + name.size() == location.size() && name.size() <= kLongestName;
  if (name.size() > kLongestName) name = name.substr(name.size() - kLongestName);
  if (name.empty()) name = "run";
  return std::filesystem::path("out") / (whole ? name : fmt::format("{}_{:08x}", name, Hash(location)));
}

std::optional<nlohmann::json> AccuracyOf(const Run& run, int64_t n_frames) {
  if (!run.trajectory || !run.truth || run.truth->empty()) return std::nullopt;
  evaluate::EvaluateOptions options;
  options.max_difference_ns = kSameMoment_ns;
  options.n_frames = n_frames;
  for (const TrajectoryPose& pose : run.keyframes.value_or(Trajectory())) options.keyframe_t_ns.push_back(pose.t_ns);
  if (run.covariance) options.covariances = *run.covariance;
  if (run.motion_covariance) options.motion_covariances = *run.motion_covariance;
  return nlohmann::json(evaluate::ToJson(evaluate::EvaluateTrajectory(*run.trajectory, *run.truth, options)));
}

std::optional<double> LiveError_m(const Run& run) {
  if (!run.live || !run.truth || run.truth->empty()) return std::nullopt;
  evaluate::EvaluateOptions options;
  options.max_difference_ns = kSameMoment_ns;
  const evaluate::Accuracy accuracy = evaluate::EvaluateTrajectory(*run.live, *run.truth, options);
  const bool known = !accuracy.pairs.empty() && std::isfinite(accuracy.ate_m.rmse);
  return known ? std::optional(accuracy.ate_m.rmse) : std::nullopt;
}

std::optional<double> PathLength_m(const Run& run) {
  if (!run.has_poses()) return std::nullopt;
  const Trajectory& trajectory = *run.trajectory;
  double length_m = 0.0;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    length_m += (trajectory[i].T_a_b.translation() - trajectory[i - 1].T_a_b.translation()).norm();
  }
  return std::isfinite(length_m) ? std::optional(length_m) : std::nullopt;
}

std::string JsonText(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

void PutWarningsIntoReport(const std::filesystem::path& out, const nlohmann::json& warnings) {
  const std::filesystem::path report = out / result_file::kReport;
  if (!std::filesystem::is_regular_file(report)) return;
  std::ifstream stream(report, std::ios::binary);
  WriteFileAtomically(report.string(), viewer::FillWarnings(viewer::ReadPage(stream), JsonText(warnings)));
}

void PutRefinementIntoReport(const std::filesystem::path& out, const std::filesystem::path& summary) {
  const std::filesystem::path report = out / result_file::kReport;
  if (!std::filesystem::is_regular_file(report)) return;
  std::ifstream stream(report, std::ios::binary);
  std::ifstream refinement(summary, std::ios::binary);
  const std::optional<std::string> page =
      viewer::FillRefinement(viewer::ReadPage(stream), viewer::ReadPage(refinement));
  if (page) WriteFileAtomically(report.string(), *page);
}

void WriteSummary(const std::filesystem::path& out, const nlohmann::json& summary) {
  WriteFileAtomically((out / result_file::kSummary).string(), JsonText(summary) + "\n");
}

}  // namespace plslam::launcher
