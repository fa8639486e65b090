// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/map_statistics.h"

namespace plslam {
namespace {

double Ratio(int64_t part, int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

void MapStatistics::Add(const MapUpdate& head) {
  if (head.source == source_ && head.version <= version_) return;
  source_ = head.source;
  version_ = head.version;
  committed_.Add(head);
  totals_ = head.totals;
  for (const auto& [stage, ms] : head.stage_ms) stage_ms_.Add(stage, ms);
  if (head.adjustment.n_points == 0) return;
  ++n_adjustments_;
  before_px_ += head.adjustment.reprojection_before_px;
  after_px_ += head.adjustment.reprojection_after_px;
}

double MapStatistics::ObservationsPerPoint() const { return Ratio(totals_.point_observations, totals_.points); }
double MapStatistics::ObservationsPerLine() const { return Ratio(totals_.line_observations, totals_.lines); }

}  // namespace plslam
