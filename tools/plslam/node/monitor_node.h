// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "core/run/published_warnings.h"
#include "tools/plslam/end_of_run.h"
#include "tools/plslam/run_statistics.h"
#include "tools/plslam/run_summary.h"
#include "tools/plslam/stall_watch.h"

namespace plslam {
class status_t;
}  // namespace plslam

namespace plslam::launcher {

/// The last status of a process.
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

/// Processes that do not keep up.
struct Lag {
  /// "mapping: 12 waiting", "loop: silent for 4 s" about the slowest one; empty if all keep up.
  std::string text;
  /// Longest queue so far by process name.
  std::map<std::string, double> longest_queue;
};

/// Listens to the run of other processes and collects its statistics. Messages published on `bus` itself do not count:
/// they are republished (HistoryKeeper).
class MonitorNode {
 public:
  /// Processes of the run that end it, by their ids on this host.
  struct Processes {
    int64_t sender = -1;  ///< of frames
    int64_t tracker = -1;
    bool has_mapper = false;  ///< there is one, on any host
  };

  explicit MonitorNode(bus::Bus& bus);

  const RunStatistics& statistics() const { return statistics_; }
  const MapStatistics& map() const { return map_; }
  const LoopStatistics& loops() const { return loops_; }
  /// Signs of the end of the run. `now_s`: steady time.
  EndSigns SignsOfEnd(const Processes& processes, double now_s) const;
  /// Number of frames that the source has published; -1 before its end.
  int64_t published_frames() const { return sent_.ended() ? total_frames_ : -1; }
  /// Newest keyframe of the run, if the map has it committed; number -1 if not, or if there is none.
  KeyframeName committed_keyframe() const;
  /// By host and process id on it; exited processes stay.
  const std::map<std::pair<std::string, int64_t>, ProcessStatus>& processes() const { return processes_; }
  /// State of a process of this host; empty if it was not heard.
  std::string StateOf(int64_t pid) const;
  /// The reason beside the state of a process of this host; empty if there is none.
  std::string ReasonOf(int64_t pid) const;
  /// The failure that a process of this host has published; empty if none.
  std::string FailureOf(int64_t pid) const;
  /// Frames counted in the status of a process of this host; 0 if it was not heard.
  int64_t FramesOf(int64_t pid) const;
  /// Returns whether a process of this name was heard, on any host.
  bool Hears(const std::string& process) const;

  /// Number of frames that the player has announced and, at its end, has sent; -1 if unknown.
  int64_t total_frames() const { return total_frames_; }
  bool stream_ended() const { return sent_.ended(); }
  /// Counts of the frames that were sent or could not be read.
  FrameTally frames() const;
  /// Counters of the processes about the data.
  const RunCounters& counters() const { return counters_; }
  /// Warnings published by the processes, each once.
  const std::vector<RunWarning>& warnings() const { return warnings_.all(); }
  /// Whether the player is paused.
  bool is_paused() const { return is_paused_; }
  /// Returns whether the player is paused; or plays at the pace of the data, has not reached the end, was heard
  /// recently, and the newest frame that it has sent has a pose. `now_s`: steady time.
  bool PlayerWaitsForTime(double now_s) const;
  /// `viewer`: process id on this host.
  SignsOfLife Signs(int64_t viewer, double now_s) const;

  /// `now_s`: steady time.
  Lag LagAt(double now_s) const;

  /// Sums over all processes.
  MessageCounts messages() const;

 private:
  void OnStatus(const status_t& message);
  bool HasAllPoses() const;
  bool KeyframesWait(double now_s) const;

  const std::string host_;
  RunStatistics statistics_;
  MapStatistics map_;
  LoopStatistics loops_;
  std::map<std::pair<std::string, int64_t>, ProcessStatus> processes_;
  std::map<std::string, double> longest_queue_;
  int64_t total_frames_ = -1;
  SentFrames sent_;
  RunCounters counters_;
  PublishedWarnings warnings_;
  int64_t poses_heard_ = 0;
  double player_heard_s_ = -1.0;
  bool lockstep_ = false;
  bool is_paused_ = false;
};

}  // namespace plslam::launcher
