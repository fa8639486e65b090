// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/bus.h"
#include "plslam/status_t.hpp"
#include "tests/support/network_host.h"
#include "tools/launch/child_process.h"

namespace plslam::test {

class StatusListener;

/// The hosts of a run's processes, except for the player; nullptr: not started.
struct HostsOfARun {
  const NetworkHost* viewer = nullptr;
  const NetworkHost* mapping = nullptr;
  const NetworkHost* loop = nullptr;
  const NetworkHost* vo = nullptr;
  const NetworkHost* recorder = nullptr;
};

/// The processes started one by one, as a user does on several machines, in one folder for all their files.
class ByHand {
 public:
  explicit ByHand(std::string url);
  ~ByHand();
  ByHand(const ByHand&) = delete;
  ByHand& operator=(const ByHand&) = delete;

  /// Starts `executable ARGUMENTS... --url URL` on that host, with the options common to all processes.
  void Start(const NetworkHost& host, const std::string& executable, std::vector<std::string> arguments = {});
  /// The same in the calling thread's network, without `--url`.
  void StartPlain(const std::string& executable, const std::vector<std::string>& arguments);
  /// Starts all processes that have a host and waits until each has published "ready" to `listener`. Fails the test
  /// otherwise.
  void StartAll(const HostsOfARun& hosts, StatusListener* listener);
  /// Plays `dataset` once.
  void StartPlayer(const NetworkHost& host, const std::string& dataset);
  /// Waits until the player has exited and the viewer has finished. Fails the test otherwise.
  void WaitUntilPlayed(StatusListener* listener);
  /// Options for all processes that are started from now on.
  void SetCommon(std::vector<std::string> arguments) { common_ = std::move(arguments); }

  /// Exit code; -1 (and killed) after `limit_s`.
  int Wait(const std::string& executable, int limit_s = 120);
  /// Sends SIGKILL, and waits for the exit.
  void Kill(const std::string& executable);
  /// Sends SIGINT to all running processes; returns true if all of them end with exit code 0.
  bool StopAll();

  const std::filesystem::path& folder() const { return folder_; }
  std::filesystem::path out() const { return folder_ / "out"; }
  std::string log() const { return (folder_ / "run.lcm").string(); }
  std::string Read(const std::string& file_of_out) const;
  std::string Logs() const;

 private:
  std::string url_;
  std::filesystem::path folder_;
  std::vector<std::string> common_;
  std::map<std::string, std::unique_ptr<launcher::ChildProcess>> processes_;
};

/// Receives the statuses of all processes and counts poses, on a host.
class StatusListener {
 public:
  StatusListener(const NetworkHost& host, const bus::BusOptions& options);
  ~StatusListener();
  StatusListener(const StatusListener&) = delete;
  StatusListener& operator=(const StatusListener&) = delete;

  using Statuses = std::map<std::string, status_t>;
  /// Returns false if `done` does not become true within the limit.
  bool WaitFor(const std::function<bool(const Statuses&, int64_t newest_frame)>& done, int limit_s = 60);
  bool WaitForState(const std::string& process, const std::string& state, int limit_s = 60);
  bool WaitForFrame(int64_t frame_id, int limit_s = 60);
  Statuses statuses() const;
  /// Returns 0 if the process or its counter is unknown.
  double Counter(const std::string& process, const std::string& name) const;
  /// Largest memory in the statuses of a process, in MB.
  double PeakMemory_mb(const std::string& process) const;
  std::string Reason(const std::string& process) const;

 private:
  std::unique_ptr<bus::Bus> bus_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Statuses statuses_;
  std::map<std::string, double> peak_mb_;
  int64_t newest_frame_ = -1;
  std::thread thread_;
};

}  // namespace plslam::test
