// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "core/io/files/folder_lock.h"

namespace plslam::launcher {

/// The folder of a run's outputs, which for the life of this object no other run writes into. Unless it is kept, what
/// was made here goes again at the end: folders, and logs of processes that came to nothing. What earlier runs have
/// left stays.
class OutputFolder {
 public:
  /// Makes `folder` and its `logs`. Throws std::runtime_error, and leaves everything as it was, where they cannot be
  /// made, or another run has the folder.
  explicit OutputFolder(const std::filesystem::path& folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  void Keep() { kept_ = true; }
  bool is_kept() const { return kept_; }
  /// Of an earlier run.
  bool has_results() const;

 private:
  void Remove() const;

  const std::filesystem::path folder_;
  std::filesystem::path first_made_;  ///< the outermost folder that there was not; empty: there were all
  std::optional<FolderLock> lock_;
  bool kept_ = false;
};

/// A folder for the runs of a dataset that name none, within out/. It is called as the end of the location, and where
/// that leaves out what another location might differ in, by a hash of all of it besides: two datasets share no
/// folder.
std::filesystem::path DefaultOut(const std::string& dataset);

/// Compares `trajectory.tum` with `groundtruth.tum` in a folder of outputs: errors by name, as `evaluate` gives them.
/// Nothing where there is no ground truth.
std::optional<nlohmann::json> EvaluateRunFiles(const std::filesystem::path& out, int64_t n_frames);

/// Absolute error of `trajectory_live.tum`, in metres. Nothing where there is no such file, no ground truth
/// or no pose that has a true one, or the error is no finite number.
std::optional<double> LiveError_m(const std::filesystem::path& out);

/// Length of `trajectory.tum`, in metres. Nothing where there is no such file, no pose in it, or no finite length.
std::optional<double> PathLength_m(const std::filesystem::path& out);

/// For people; bytes that are not UTF-8 (names, sentences of others) are replaced.
std::string JsonText(const nlohmann::json& json);

/// Puts the warnings of the summary into `report.html`, where there is one. Throws std::runtime_error where that
/// fails.
void PutWarningsIntoReport(const std::filesystem::path& out, const nlohmann::json& warnings);

/// Writes `summary.json` (beside it first, then renamed). Throws std::runtime_error where that fails.
void WriteSummary(const std::filesystem::path& out, const nlohmann::json& summary);

}  // namespace plslam::launcher
