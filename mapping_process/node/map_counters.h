// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "core/process/process.h"
#include "mapping_process/mapper.h"

namespace plslam::mapping {

/// Counters of the map in the status of mapping_process.
class MapCounters {
 public:
  explicit MapCounters(bus::Process& process) : process_(process) {}

  void CountIgnored() { process_.SetCounter("keyframes.ignored", static_cast<double>(++n_ignored_)); }
  void CountMissing(int64_t n) { process_.SetCounter("keyframes.missing", static_cast<double>(n_missing_ += n)); }
  /// Publishes the size of the map. Reports the first adjustment that failed.
  void Count(const Mapper& mapper);

 private:
  bus::Process& process_;
  int64_t n_ignored_ = 0;
  int64_t n_missing_ = 0;
  int64_t n_failed_ = 0;  ///< adjustments
};

}  // namespace plslam::mapping
