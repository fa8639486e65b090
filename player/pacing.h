// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "player/options.h"

namespace plslam::player {

/// When frames are sent.
struct Pace {
  bool lockstep = true;
  double speed = 1.0;  ///< real time only: 2 is twice as fast
};

/// From "lockstep", "realtime", "realtimex2", "realtimex0.5" (0.001 to 1000). Throws std::runtime_error.
Pace ParsePace(const std::string& text);

/// The newest frame that has been answered, where a player goes on that was started again.
struct ResumePoint {
  int64_t frame_id = -1;
  int64_t t_ns = 0;

  bool operator==(const ResumePoint&) const = default;
};

/// From "ID@T_NS", as `player.resume_after` says it. Throws std::runtime_error.
ResumePoint ParseResumePoint(const std::string& text);
std::string ToText(const ResumePoint& point);

/// Frames in the order in which they are played, with continuing times: a pass over the dataset after another follows
/// at the mean distance of frames; on the way back (`bounce`) times go on by the same distances.
class PlayOrder {
 public:
  struct Item {
    int index = 0;
    int64_t t_ns = 0;
  };

  /// `times_ns` are those of the whole dataset, increasing; `rate_hz` serves where only one frame is played. Throws
  /// std::runtime_error where the options leave no frame.
  PlayOrder(const std::vector<int64_t>& times_ns, const PlayerOptions& options, double rate_hz);

  /// Number of items in all.
  int64_t size() const { return size_; }
  /// The frames of the dataset that are played, each once, with their own times.
  const std::vector<Item>& pass() const { return pass_; }
  std::optional<Item> Next();
  /// Leaves out what is not later than `t_ns`; how many that is.
  int64_t SkipTo(int64_t t_ns);
  /// Mean distance in time of the frames played.
  int64_t period_ns() const { return period_ns_; }

 private:
  size_t Position(int64_t step) const;

  std::vector<Item> pass_;
  bool bounce_;
  int64_t size_;
  int64_t period_ns_;
  int64_t step_ = 0;
  int64_t t_ns_ = 0;
};

/// Maps the time of frames to that of a steady clock (both in nanoseconds): the first frame is due at once.
class RealtimeClock {
 public:
  /// Frames sent more than half a period after they were due are late.
  RealtimeClock(double speed, int64_t period_ns);

  int64_t Due_ns(int64_t t_ns, int64_t now_ns);
  /// Everything is due so much later from now on.
  void Delay(int64_t by_ns) { first_due_ns_ += by_ns; }
  bool IsLate(int64_t due_ns, int64_t now_ns) const { return now_ns - due_ns > tolerance_ns_; }

 private:
  double speed_;
  int64_t tolerance_ns_;
  std::optional<int64_t> first_t_ns_;
  int64_t first_due_ns_ = 0;
};

}  // namespace plslam::player
