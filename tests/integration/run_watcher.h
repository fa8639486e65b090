// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "core/bus/messages/keyframe_channel.h"
#include "core/bus/messages/map_channel.h"
#include "plslam/status_t.hpp"
#include "tools/launch/run_bus.h"

namespace plslam::test {

/// State of a run as heard by a listener.
struct Heard {
  /// The first pose of each frame, by session: encoded, without header and stages.
  std::map<int64_t, std::map<int64_t, std::vector<uint8_t>>> poses;
  std::map<int64_t, double> pose_at_s;  ///< by frame: when, of the steady clock
  int64_t poses_said_again = 0;         ///< by a restarted tracker, or by the history keeper
  int64_t poses_said_otherwise = 0;     ///< of these, the ones that differ in any bit
  std::set<int64_t> frames;
  int64_t newest_frame = -1;
  int64_t lost_frames = 0;
  /// Numbers of the keyframes by session.
  std::map<SessionId, std::set<int64_t>> keyframes;
  /// The same, of those that are in the map.
  std::map<SessionId, std::set<int64_t>> mapped;
  SourceId map_source;  ///< publisher of that map
  /// Newest status by process name.
  std::map<std::string, status_t> status;
  /// Names and ids of processes that have published "ready" or "running".
  std::set<std::pair<std::string, int64_t>> ready;
  /// Times of each process's first message, and of its first status "running": by name and id, of the steady clock.
  std::map<std::pair<std::string, int64_t>, double> alive_at_s, running_at_s;

  /// Counter in the newest status of a process; 0 if it has none of this name.
  double Counter(const std::string& process, const std::string& name) const;
  /// Whether `mapped` is the map of the mapping_process with this id.
  bool IsMapOf(pid_t pid) const;
};

/// Listens to a run on its own bus and thread, and lets a test wait for messages.
class RunWatcher {
 public:
  /// On a private port of this machine.
  RunWatcher();
  ~RunWatcher();
  RunWatcher(const RunWatcher&) = delete;
  RunWatcher& operator=(const RunWatcher&) = delete;

  std::string url() const { return port_.Url(); }

  /// Returns false if `done` does not become true within `limit_s`.
  bool WaitFor(const std::function<bool(const Heard&)>& done, int limit_s = 60) const;
  bool WaitForFrame(int64_t frame_id, int limit_s = 60) const;
  /// Waits until a process of this name with this id has published "ready" or "running".
  bool WaitUntilReady(const std::string& process, pid_t pid, int limit_s = 60) const;
  Heard Get() const;

 private:
  void Listen();
  template <class Change>
  void Add(const Change& change);

  launcher::PrivatePort port_;
  bus::Bus bus_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  Heard heard_;
  std::unique_ptr<bus::KeyframeSubscriber> keyframes_;
  std::unique_ptr<bus::MapSubscriber> map_;
  std::thread thread_;
};

}  // namespace plslam::test
