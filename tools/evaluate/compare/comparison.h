// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/run_record.h"

namespace plslam::evaluate {

/// Statistics of a metric over the completed runs of a group that have it.
struct Spread {
  int n = 0;
  double median = 0.0;  ///< mean of the two middle values if `n` is even
  double worst = 0.0;
  double spread = 0.0;  ///< largest minus smallest
};

Spread SpreadOf(std::vector<double> values, bool larger_is_better);

/// Runs of one dataset with the same options.
struct RunGroup {
  std::string dataset;
  /// The options that differ among all the compared runs ("features=points"); "same options" without differences.
  std::string label;
  std::vector<RunRecord> runs;
  int failed = 0;
  int untracked = 0;  ///< of the completed ones
  /// As Metrics() has them.
  std::vector<Spread> metrics;

  /// Values of a metric in the completed runs that have it.
  std::vector<double> Values(size_t metric) const;

  /// Returns the completed run whose first metric is nearest to the median, the first of equal ones; nullptr if there
  /// is none.
  const RunRecord* Typical() const;
};

/// Returns groups in the order of their first runs; groups of one dataset are consecutive.
std::vector<RunGroup> Compare(const std::vector<RunRecord>& runs);

/// Returns the metrics that any of the groups has.
std::vector<size_t> KnownMetrics(const std::vector<const RunGroup*>& groups);

/// Returns the value of an option; "-" if the run has no such option.
std::string ValueOf(const RunRecord& run, const std::string& option);
/// Names of the options that differ between the runs that have them, in their order, after kProcesses: a run without a
/// process does not have its options.
std::vector<std::string> DifferingOptions(const std::vector<const RunRecord*>& runs);

}  // namespace plslam::evaluate
