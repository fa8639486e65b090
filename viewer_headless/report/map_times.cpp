// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/map_times.h"

#include <algorithm>
#include <limits>

namespace plslam::viewer {
namespace {

constexpr size_t kMaxRows = 4000;
constexpr size_t kMaxStages = 32;

}  // namespace

void MapTimes::Add(const MapUpdate& update, FrameId frame_id) {
  // A republished complete map repeats the times of the last update.
  if (update.IsWhole() && update.version != 1) return;
  if (update.stage_ms.empty() || heard_++ % every_ != 0) return;
  Row row;
  row.frame = Clamp32(frame_id.value);
  row.before_px = static_cast<float>(update.adjustment.reprojection_before_px);
  row.after_px = static_cast<float>(update.adjustment.reprojection_after_px);
  for (const auto& [name, ms] : update.stage_ms) {
    const auto found = std::find(stage_names_.begin(), stage_names_.end(), name);
    const auto index = static_cast<size_t>(found - stage_names_.begin());
    if (index >= kMaxStages) continue;
    if (found == stage_names_.end()) stage_names_.push_back(name);
    row.stages_ms.resize(std::max(row.stages_ms.size(), index + 1), std::numeric_limits<float>::quiet_NaN());
    row.stages_ms[index] = static_cast<float>(ms);
  }
  rows_.push_back(std::move(row));
  if (rows_.size() <= kMaxRows) return;
  KeepEverySecond(rows_);
  every_ *= 2;
}

Table MapTimes::Times() const {
  std::vector<int32_t> frame;
  std::vector<float> stages_ms, before_px, after_px;
  for (const Row& row : rows_) {
    frame.push_back(row.frame);
    before_px.push_back(row.before_px);
    after_px.push_back(row.after_px);
    AppendRow(row.stages_ms, stage_names_.size(), stages_ms);
  }
  const int width = std::max(1, static_cast<int>(stage_names_.size()));
  return {{"frame", 1, std::move(frame)},
          {"stages_ms", width, std::move(stages_ms)},
          {"before_px", 1, std::move(before_px)},
          {"after_px", 1, std::move(after_px)}};
}

}  // namespace plslam::viewer
