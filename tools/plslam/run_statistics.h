// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/loop_closure.h"
#include "core/map/map_follower.h"
#include "core/map/map_update.h"
#include "core/run/frame_tally.h"

namespace plslam::launcher {

/// Counts different numbers of sessions. They ascend nearly without gaps, so each costs little more than a bit: a set
/// of landmarks was the greatest part of the memory of a long run's launcher.
class IdCounter {
 public:
  /// Negative ones do not count.
  void Add(SessionId session, int64_t id);
  int64_t count() const { return count_; }
  /// Memory of the counted ids, in bytes; at most 40 MB: other programs may forge ids.
  int64_t bytes() const;

 private:
  static constexpr int64_t kBlock = 4096;
  static constexpr size_t kMaxBlocks = 65536;

  std::map<std::pair<SessionId, int64_t>, std::bitset<kBlock>> blocks_;  // by session and id / kBlock
  int64_t count_ = 0;
};

/// Median and other quantiles of positive numbers in fixed memory, regardless of their number: a histogram whose bins
/// grow by 1 %, so that a quantile is within 0.5 % of the exact one (for values of 1e-4 to 1e6; others are clamped).
class QuantileSketch {
 public:
  void Add(double value);
  int64_t count() const { return count_; }
  /// The value below which a share of `q` (0 to 1) of the numbers lies (nearest rank); 0 without numbers.
  double Quantile(double q) const;

 private:
  static constexpr int kBins = 2320;  // 1e-4 * 1.01^2320 > 1e6

  std::array<int64_t, kBins> bins_{};
  int64_t count_ = 0;
  double min_ = 0.0;
  double max_ = 0.0;
};

/// Times in ms by stage. Names are received from the network and may be forged: those beyond `kMaxStages` are ignored.
class StageTimes {
 public:
  static constexpr size_t kMaxStages = 64;

  void Add(const std::string& stage, double ms) {
    if (times_.size() < kMaxStages || times_.contains(stage)) times_[stage].Add(ms);
  }
  const std::map<std::string, QuantileSketch>& by_name() const { return times_; }

 private:
  std::map<std::string, QuantileSketch> times_;
};

/// Counts the messages of loop_process in a run; the number of loops in the map, with those of a loaded map, is in
/// `MapTotals`.
class LoopStatistics {
 public:
  void Add(LoopClosure::Kind kind, double detect_ms, double correct_ms);
  void AddAnswer(bool found);

  int64_t keyframes() const { return detect_ms_.count() + correct_ms_.count(); }
  int64_t loops() const { return correct_ms_.count(); }
  int64_t asked() const { return asked_; }
  int64_t found() const { return found_; }
  /// Times of keyframes without a loop closure; of those with one, including the correction; and of global bundle
  /// adjustments.
  const QuantileSketch& detect_ms() const { return detect_ms_; }
  const QuantileSketch& correct_ms() const { return correct_ms_; }
  const QuantileSketch& adjust_ms() const { return adjust_ms_; }

 private:
  QuantileSketch detect_ms_;
  QuantileSketch correct_ms_;
  QuantileSketch adjust_ms_;
  int64_t asked_ = 0;
  int64_t found_ = 0;
};

/// Counts the updates of the map by their heads; content is ignored.
class MapStatistics {
 public:
  /// A version that was counted before is ignored: the complete map may be republished.
  void Add(const MapUpdate& head);

  /// 0: there is no map.
  int64_t version() const { return version_; }
  /// Totals of the newest version.
  const MapTotals& totals() const { return totals_; }
  const NewestKeyframes& newest() const { return newest_; }

  /// Mean number of keyframes that observe a landmark; 0 without landmarks.
  double ObservationsPerPoint() const;
  double ObservationsPerLine() const;

  /// By stage, ms; of all updates, including those of a process that was killed.
  const std::map<std::string, QuantileSketch>& stage_ms() const { return stage_ms_.by_name(); }
  /// Means over the adjustments that had points, of their root mean squares; nullopt without any.
  std::optional<double> ReprojectionBefore_px() const { return Mean(before_px_); }
  std::optional<double> ReprojectionAfter_px() const { return Mean(after_px_); }

 private:
  std::optional<double> Mean(double sum) const {
    return n_adjustments_ > 0 ? std::optional(sum / static_cast<double>(n_adjustments_)) : std::nullopt;
  }

  SourceId source_;
  int64_t version_ = 0;
  NewestKeyframes newest_;
  MapTotals totals_;
  StageTimes stage_ms_;
  int64_t n_adjustments_ = 0;
  double before_px_ = 0.0;
  double after_px_ = 0.0;
};

/// Content of a frame's pose message.
struct FrameReport {
  SessionId session;
  FrameId frame_id = 0;
  int64_t t_ns = 0;
  TrackingState state = TrackingState::kInitialising;
  int64_t keyframe_id = -1;
  int tracked_points = 0;
  int tracked_lines = 0;
  int skipped_frames = 0;
  double age_ms = 0.0;  ///< of the frame when its pose was published
  int features = 0;
  int moving = 0;  ///< features on moving bodies, and bodies of the session so far
  int bodies = 0;
  std::vector<std::pair<std::string, double>> stage_ms;
};

/// Counts a run, frame by frame, in memory that hardly grows with its length: by a bit for each landmark.
class RunStatistics {
 public:
  void AddFrame(const FrameReport& frame);
  void AddLandmark(SessionId session, TrackId landmark_id, bool is_line);

  /// Frames with a pose message, and the skipped frames in those messages; a frame that a restarted tracker repeats is
  /// counted once.
  const FrameTally& frames() const { return frames_; }
  const MovingTally& moving() const { return moving_; }
  int64_t keyframes() const { return keyframes_; }
  int64_t landmark_points() const { return points_.count(); }
  int64_t landmark_lines() const { return lines_.count(); }
  const FrameReport& last() const { return last_; }
  /// Sessions of the frames: the first ones of very many.
  const std::set<SessionId>& sessions() const { return sessions_; }
  /// Number and time of the newest frame that has a pose; -1: none.
  std::pair<FrameId, int64_t> newest_frame() const { return {newest_frame_id_, newest_t_ns_}; }
  /// Session and number there of the newest keyframe; -1: none.
  KeyframeName last_keyframe() const { return last_keyframe_; }
  const std::map<std::string, QuantileSketch>& stage_ms() const { return stage_ms_.by_name(); }
  /// Ages of the frames when their poses were published.
  const QuantileSketch& age_ms() const { return age_ms_; }

 private:
  FrameTally frames_;
  MovingTally moving_;
  int64_t keyframes_ = 0;
  FrameId newest_frame_id_ = -1;
  int64_t newest_t_ns_ = 0;
  FrameReport last_;
  std::set<SessionId> sessions_;
  KeyframeName last_keyframe_;
  StageTimes stage_ms_;
  QuantileSketch age_ms_;
  IdCounter points_;
  IdCounter lines_;
};

}  // namespace plslam::launcher
