// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>

#include "core/bus/bus.h"
#include "tools/plslam/run_statistics.h"
#include "tools/plslam/run_summary.h"
#include "tools/plslam/stall_watch.h"

namespace plslam {
class status_t;
}  // namespace plslam

namespace plslam::launcher {

/// What a process last said of itself.
struct ProcessStatus {
  std::string process;
  std::string state;
  std::string reason;
  std::string configuration;
  MessageCounts messages;
  double queue = 0.0;  ///< longest of its queues
  int64_t frames = 0;  ///< that it has handled
  double heard_s = 0.0;
};

/// Who keeps up, and who does not.
struct Lag {
  /// "mapping: 12 waiting", "loop: silent for 4 s" of the one furthest behind; empty where none is.
  std::string text;
  /// Longest queue so far by process name.
  std::map<std::string, double> longest_queue;
};

/// Listens to the run of other processes and keeps its statistics. What is said on `bus` itself does not count: it is
/// what others have said before (HistoryKeeper).
class MonitorNode {
 public:
  explicit MonitorNode(bus::Bus& bus);

  const RunStatistics& statistics() const { return statistics_; }
  const MapStatistics& map() const { return map_; }
  const LoopStatistics& loops() const { return loops_; }
  /// Every frame that was sent is counted, and where there is a map it has the last keyframe, committed.
  bool has_all() const;
  /// By host and process id there; those of processes that have ended stay.
  const std::map<std::pair<std::string, int64_t>, ProcessStatus>& processes() const { return processes_; }
  /// Of a process of this host; empty where it has not been heard.
  std::string StateOf(int64_t pid) const;
  /// What a process of this host said of its own failure; empty where it said nothing.
  std::string FailureOf(int64_t pid) const;
  /// Frames that a process of this host has told of; 0 where it has not been heard.
  int64_t FramesOf(int64_t pid) const;
  /// A process of this name has been heard, on any host.
  bool Hears(const std::string& process) const;

  /// Frames the player has announced, and, when it is through, has sent; -1 where unknown.
  int64_t total_frames() const { return total_frames_; }
  bool stream_ended() const { return sent_.ended(); }
  /// What became of the frames that were sent or could not be.
  FrameTally frames() const;
  /// What the processes say of the data.
  const RunCounters& counters() const { return counters_; }
  /// Somebody has paused the player.
  bool is_paused() const { return is_paused_; }
  /// It is paused; or it plays at the pace of the data and has not come to the end, was heard of late, and the newest frame it says it
  /// has sent has a pose. `now_s`: steady time.
  bool PlayerWaitsForTime(double now_s) const;
  /// `viewer`: process id on this host.
  SignsOfLife Signs(int64_t viewer, double now_s) const;

  /// `now_s`: steady time.
  Lag LagAt(double now_s) const;

  /// Sums over all processes.
  MessageCounts messages() const;

 private:
  void OnStatus(const status_t& message);

  const std::string host_;
  RunStatistics statistics_;
  MapStatistics map_;
  LoopStatistics loops_;
  std::map<std::pair<std::string, int64_t>, ProcessStatus> processes_;
  std::map<std::string, double> longest_queue_;
  int64_t total_frames_ = -1;
  SentFrames sent_;
  RunCounters counters_;
  int64_t poses_heard_ = 0;
  double player_heard_s_ = -1.0;
  bool lockstep_ = false;
  bool is_paused_ = false;
};

}  // namespace plslam::launcher
