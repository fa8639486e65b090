// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace plslam::evaluate {

/// The object in `FOLDER/summary.json` of a run. Throws std::runtime_error, which names the file, where there is
/// none.
nlohmann::json ReadRunSummary(const std::string& folder);

/// A number that runs are compared by.
struct Metric {
  std::string key;   ///< in JSON and CSV: "ate_m"
  std::string name;  ///< in tables: "ATE"
  std::string unit;
  /// Digits behind the point.
  int digits = 3;
  bool larger_is_better = false;
  /// Some just tell how a run went.
  bool has_best = true;
};

/// "ATE [m]".
std::string NameWithUnit(const Metric& metric);

/// All there are, in the order of the columns. docs/metrics.md says what they are.
const std::vector<Metric>& Metrics();

/// What is compared of a run.
struct RunRecord {
  std::string folder;
  /// What was played, and that without the seed of built-in worlds, which is no difference that matters.
  std::string played;
  std::string dataset;
  bool completed = false;
  /// There is a truth, and not one pose to compare with it: no errors are told, which must not be taken for a good
  /// run.
  bool untracked = false;
  /// Why it is not completed.
  std::string reason;
  /// Options by their full name ("vo.features.features"), and under `processes` and `version` what ran. Left out is
  /// what differs between runs that mean the same: bus, folders, map files, seeds.
  std::map<std::string, std::string> options;
  /// As Metrics() has them; nullopt: the run does not tell.
  std::vector<std::optional<double>> values;
};

/// From a `summary.json`. `folder` is for the record only.
RunRecord RecordOf(const nlohmann::json& summary, const std::string& folder);

/// From `FOLDER/summary.json`; nullopt where that is not the summary of a run.
std::optional<RunRecord> FindRunRecord(const std::string& folder);

}  // namespace plslam::evaluate
