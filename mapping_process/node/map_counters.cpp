// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/map_counters.h"

#include "core/errors/log.h"

namespace plslam::mapping {

void MapCounters::Count(const Mapper& mapper) {
  process_.SetCounter("map.version", static_cast<double>(mapper.version()));
  process_.SetCounter("map.keyframes", static_cast<double>(mapper.map().keyframes().size()));
  process_.SetCounter("map.points", static_cast<double>(mapper.map().points().size()));
  process_.SetCounter("map.lines", static_cast<double>(mapper.map().lines().size()));
  process_.SetCounter("map.loops", static_cast<double>(mapper.map().loops().size()));
  const Mapper::Failures& failures = mapper.failures();
  if (failures.count == n_failed_) return;
  if (n_failed_ == 0) LogWarning("a local bundle adjustment failed (later ones are counted only): {}", failures.last);
  process_.SetCounter("adjustments.failed", static_cast<double>(n_failed_ = failures.count));
}

}  // namespace plslam::mapping
