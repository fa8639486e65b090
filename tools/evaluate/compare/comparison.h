// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "tools/evaluate/run_record.h"

namespace plslam::evaluate {

/// Of a metric over the runs of a group that were completed and tell it.
struct Spread {
  int n = 0;
  double median = 0.0;  ///< mean of the two middle values where `n` is even
  double worst = 0.0;
  double spread = 0.0;  ///< largest less smallest
};

Spread SpreadOf(std::vector<double> values, bool larger_is_better);

/// Runs of one dataset with the same options.
struct RunGroup {
  std::string dataset;
  /// The options that differ among all the runs compared ("features=points"); "all alike" where none do.
  std::string label;
  std::vector<RunRecord> runs;
  int failed = 0;
  int untracked = 0;  ///< of the completed ones
  /// As Metrics() has them.
  std::vector<Spread> metrics;

  /// Of a metric, from the completed runs that tell it.
  std::vector<double> Values(size_t metric) const;

  /// The completed run whose first metric is nearest to the median, at a tie the first; nullptr where there is none.
  const RunRecord* Typical() const;
};

/// Groups in the order in which their first runs come; groups of one dataset follow each other.
std::vector<RunGroup> Compare(const std::vector<RunRecord>& runs);

/// The metrics that any of the groups knows.
std::vector<size_t> KnownMetrics(const std::vector<const RunGroup*>& groups);

/// Value of an option; "-" where the run has no such option.
std::string ValueOf(const RunRecord& run, const std::string& option);
/// Names of the options that are not the same in all runs, in their order.
std::vector<std::string> DifferingOptions(const std::vector<const RunRecord*>& runs);

}  // namespace plslam::evaluate
