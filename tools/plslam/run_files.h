// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/files/folder_lock.h"
#include "core/run/run.h"

namespace plslam::launcher {

/// The folder of a run's outputs; no other run can write into it during the life of this object. Unless it is kept,
/// everything that was created here is removed at the end: folders, and logs of failed processes. Results of earlier
/// runs are kept.
class OutputFolder {
 public:
  /// Creates `folder` and its `logs`. Throws std::runtime_error, without any change, if they cannot be created, or
  /// another run has the folder.
  explicit OutputFolder(const std::filesystem::path& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  void Keep() { kept_ = true; }
  bool is_kept() const { return kept_; }
  /// Returns whether it has results of an earlier run.
  bool has_results() const;

 private:
  void Remove() const;

  const std::filesystem::path folder_;
  std::filesystem::path first_made_;  ///< the outermost folder that there was not; empty: there were all
  std::optional<FolderLock> lock_;
  bool kept_ = false;
};

/// Returns a folder within out/ for the runs of a dataset without `--out`. It is named after the end of the location,
/// and by a hash of all of it if the name omits possible differences: two datasets share no folder.
std::filesystem::path DefaultOut(const std::string& dataset);

/// Compares the trajectory of a run with the truth: errors by name, as in `evaluate`. Returns nullopt without either.
std::optional<nlohmann::json> AccuracyOf(const Run& run, int64_t n_frames);

/// Returns the absolute error of the poses as published, in metres; nullopt without them, without ground truth or
/// associated poses, or if the error is not finite.
std::optional<double> LiveError_m(const Run& run);

/// Returns the length of the trajectory, in metres; nullopt without poses, or if the length is not finite.
std::optional<double> PathLength_m(const Run& run);

/// Returns JSON for users; bytes that are not UTF-8 (names, sentences of others) are replaced.
std::string JsonText(const nlohmann::json& json);

/// Puts the warnings of the summary into `report.html`, if there is one. Throws std::runtime_error if that fails.
void PutWarningsIntoReport(const std::filesystem::path& out, const nlohmann::json& warnings);

/// Puts the summary of a refinement, from its file, into `report.html`, if there is one with a place for it. Throws
/// std::runtime_error if that fails.
void PutRefinementIntoReport(const std::filesystem::path& out, const std::filesystem::path& summary);

/// Writes `summary.json` (beside it first, then renamed). Throws std::runtime_error if that fails.
void WriteSummary(const std::filesystem::path& out, const nlohmann::json& summary);

}  // namespace plslam::launcher
