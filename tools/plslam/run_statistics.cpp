// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/run_statistics.h"

#include <algorithm>
#include <cmath>

namespace plslam::launcher {

void IdCounter::Add(SessionId session, int64_t id) {
  if (id < 0) return;
  const std::pair block(session, id / kBlock);
  if (blocks_.size() >= kMaxBlocks && !blocks_.contains(block)) return;
  auto bit = blocks_[block][static_cast<size_t>(id % kBlock)];
  if (bit) return;
  bit = true;
  ++count_;
}

int64_t IdCounter::bytes() const {
  return static_cast<int64_t>(blocks_.size() * sizeof(decltype(blocks_)::value_type));
}

namespace {

// Sessions that are remembered; each restart of a tracker may begin one.
constexpr size_t kMostSessions = 1000;
constexpr double kSmallest = 1e-4;
const double kLogRatio = std::log(1.01);

}  // namespace

void QuantileSketch::Add(double value) {
  if (!std::isfinite(value)) return;
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  const double bin = value > kSmallest ? std::floor(std::log(value / kSmallest) / kLogRatio) : 0.0;
  ++bins_[static_cast<size_t>(std::clamp(bin, 0.0, static_cast<double>(kBins - 1)))];
  ++count_;
}

double QuantileSketch::Quantile(double q) const {
  if (count_ == 0) return 0.0;
  const auto rank = std::clamp<int64_t>(std::llround(std::ceil(q * static_cast<double>(count_))), 1, count_);
  int64_t seen = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    seen += bins_[bin];
    if (seen >= rank) return std::clamp(kSmallest * std::exp((bin + 0.5) * kLogRatio), min_, max_);
  }
  return max_;
}

void LoopStatistics::Add(LoopClosure::Kind kind, double detect_ms, double correct_ms) {
  if (kind == LoopClosure::Kind::kAdjustment) return adjust_ms_.Add(correct_ms);
  if (kind == LoopClosure::Kind::kLoop) return correct_ms_.Add(correct_ms);
  detect_ms_.Add(detect_ms);
}

void LoopStatistics::AddAnswer(bool found) {
  ++asked_;
  if (found) ++found_;
}

namespace {

double Ratio(int64_t part, int64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 0.0;
}

}  // namespace

void MapStatistics::Add(const MapUpdate& head) {
  if (head.source == source_ && head.version <= version_) return;
  source_ = head.source;
  version_ = head.version;
  newest_.Add(head);
  totals_ = head.totals;
  for (const auto& [stage, ms] : head.stage_ms) stage_ms_.Add(stage, ms);
  if (head.adjustment.n_points == 0) return;
  ++n_adjustments_;
  before_px_ += head.adjustment.reprojection_before_px;
  after_px_ += head.adjustment.reprojection_after_px;
}

double MapStatistics::ObservationsPerPoint() const { return Ratio(totals_.point_observations, totals_.points); }
double MapStatistics::ObservationsPerLine() const { return Ratio(totals_.line_observations, totals_.lines); }

void RunStatistics::AddFrame(const FrameReport& frame) {
  last_ = frame;
  // A tracker that was started again answers frames again.
  if (frame.frame_id <= newest_frame_id_) return;
  for (const auto& [stage, ms] : frame.stage_ms) stage_ms_.Add(stage, ms);
  age_ms_.Add(frame.age_ms);
  // At most the number of ids since the previous frame, whatever the message claims.
  const int64_t between = frame.frame_id.value - newest_frame_id_.value - 1;
  frames_.skipped += std::clamp<int64_t>(frame.skipped_frames, 0, between);
  if (frame.keyframe_id >= 0) {
    ++keyframes_;
    last_keyframe_ = {frame.session, frame.keyframe_id};
  }
  if (sessions_.size() < kMostSessions) sessions_.insert(frame.session);
  newest_frame_id_ = frame.frame_id;
  newest_t_ns_ = frame.t_ns;
  moving_.Add(frame.frame_id, frame.moving, frame.features, frame.bodies);
  frames_.Count(frame.state, frame.keyframe_id);
}

void RunStatistics::AddLandmark(SessionId session, TrackId landmark_id, bool is_line) {
  (is_line ? lines_ : points_).Add(session, landmark_id.value);
}

}  // namespace plslam::launcher
