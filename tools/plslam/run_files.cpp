// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_files.h"

#include <cctype>
#include <cmath>
#include <fstream>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "core/io/files/atomic_file.h"
#include "core/io/trajectories/pose_covariance.h"
#include "core/io/trajectories/trajectory.h"
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

bool OutputFolder::has_results() const { return std::filesystem::exists(folder_ / "summary.json"); }

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

/// Returns nullopt unless both exist.
std::optional<std::pair<Trajectory, Trajectory>> EstimateAndTruth(const std::filesystem::path& out,
                                                                  const char* estimate) {
  const auto estimate_path = out / estimate, truth_path = out / "groundtruth.tum";
  if (!std::filesystem::is_regular_file(estimate_path) || !std::filesystem::is_regular_file(truth_path))
    return std::nullopt;
  Trajectory truth = ReadTrajectory(truth_path, TrajectoryFormat::kTum);
  if (truth.empty()) return std::nullopt;
  return std::pair(ReadTrajectory(estimate_path, TrajectoryFormat::kTum), std::move(truth));
}

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

std::optional<double> LiveError_m(const std::filesystem::path& out) {
  const auto both = EstimateAndTruth(out, "trajectory_live.tum");
  if (!both) return std::nullopt;
  evaluate::EvaluateOptions options;
  options.max_difference_ns = kSameMoment_ns;
  const evaluate::Accuracy accuracy = evaluate::EvaluateTrajectory(both->first, both->second, options);
  const bool known = !accuracy.pairs.empty() && std::isfinite(accuracy.ate_m.rmse);
  return known ? std::optional(accuracy.ate_m.rmse) : std::nullopt;
}

std::optional<double> PathLength_m(const std::filesystem::path& out) {
  const auto path = out / "trajectory.tum";
  if (!std::filesystem::is_regular_file(path)) return std::nullopt;
  const Trajectory trajectory = ReadTrajectory(path, TrajectoryFormat::kTum);
  double length_m = 0.0;
  for (size_t i = 1; i < trajectory.size(); ++i) {
    length_m += (trajectory[i].T_a_b.translation() - trajectory[i - 1].T_a_b.translation()).norm();
  }
  return !trajectory.empty() && std::isfinite(length_m) ? std::optional(length_m) : std::nullopt;
}

std::optional<nlohmann::json> EvaluateRunFiles(const std::filesystem::path& out, int64_t n_frames) {
  const auto both = EstimateAndTruth(out, "trajectory.tum");
  if (!both) return std::nullopt;
  const auto keyframes_path = out / "keyframes.tum";
  evaluate::EvaluateOptions options;
  options.max_difference_ns = kSameMoment_ns;
  options.n_frames = n_frames;
  if (std::filesystem::is_regular_file(keyframes_path)) {
    for (const TrajectoryPose& pose : ReadTrajectory(keyframes_path, TrajectoryFormat::kTum)) {
      options.keyframe_t_ns.push_back(pose.t_ns);
    }
  }
  if (std::filesystem::is_regular_file(out / "covariance.txt")) {
    options.covariances = ReadPoseCovariances(out / "covariance.txt");
  }
  if (std::filesystem::is_regular_file(out / "motion_covariance.txt")) {
    options.motion_covariances = ReadPoseCovariances(out / "motion_covariance.txt");
  }
  return nlohmann::json(evaluate::ToJson(evaluate::EvaluateTrajectory(both->first, both->second, options)));
}

std::string JsonText(const nlohmann::json& json) {
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace);
}

void PutWarningsIntoReport(const std::filesystem::path& out, const nlohmann::json& warnings) {
  const std::filesystem::path report = out / "report.html";
  if (!std::filesystem::is_regular_file(report)) return;
  std::ifstream stream(report, std::ios::binary);
  WriteFileAtomically(report.string(), viewer::FillWarnings(viewer::ReadPage(stream), JsonText(warnings)));
}

void WriteSummary(const std::filesystem::path& out, const nlohmann::json& summary) {
  WriteFileAtomically((out / "summary.json").string(), JsonText(summary) + "\n");
}

}  // namespace plslam::launcher
