// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace plslam::evaluate {

/// A number that runs are compared by.
struct Metric {
  std::string key;   ///< in JSON and CSV: "ate_m"
  std::string name;  ///< in tables: "ATE"
  std::string unit;
  /// Digits after the decimal point.
  int digits = 3;
  bool larger_is_better = false;
  /// Some metrics only describe a run.
  bool has_best = true;
};

/// "ATE [m]".
std::string NameWithUnit(const Metric& metric);

/// Returns all metrics, in the order of the columns; docs/metrics.md defines them.
const std::vector<Metric>& Metrics();

/// The entry of RunRecord::options with the processes of the run: "loop+mapping+vo".
inline constexpr char kProcesses[] = "processes";

/// The compared values of a run.
struct RunRecord {
  std::string folder;
  /// The dataset of the run, with and without the seed of a built-in world; seeds do not distinguish groups.
  std::string played;
  std::string dataset;
  /// The LCM logs that it recorded.
  std::vector<std::string> recordings;
  bool completed = false;
  /// There is a truth but no pose to compare with it: the run has no errors, which must not be mistaken for a good
  /// result.
  bool untracked = false;
  /// The reason why it is not completed.
  std::string reason;
  /// Options by full name ("vo.features.features"), and the processes and version under `processes` and `version`.
  /// Options that differ between equivalent runs are left out: bus, folders, map files, seeds, the format of the dataset.
  std::map<std::string, std::string> options;
  /// In the order of Metrics(); nullopt: the run does not have the value.
  std::vector<std::optional<double>> values;
};

/// From a `summary.json`. `folder` is for the record only.
RunRecord RecordOf(const nlohmann::json& summary, const std::string& folder);

/// Gives a run that played a recording of another one the dataset of the latter: both processed the same frames.
void ResolveRecordings(std::vector<RunRecord>* runs);

/// Reads `FOLDER/summary.json`; nullopt if that is not the summary of a run.
std::optional<RunRecord> FindRunRecord(const std::string& folder);

}  // namespace plslam::evaluate
