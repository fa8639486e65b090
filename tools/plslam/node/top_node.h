// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "core/bus/bus.h"
#include "tools/plslam/run_statistics.h"

namespace plslam {
class status_t;
}  // namespace plslam

namespace plslam::launcher {

/// The last status of a process. Rates and CPU load refer to the time between its last two statuses; negative if there
/// was only one.
struct ProcessLoad {
  std::string robot;  ///< prefix of its channels
  std::string process;
  std::string host;
  int64_t pid = 0;
  std::string state;
  std::string reason;
  double heard_s_ago = 0.0;
  double uptime_s = 0.0;
  double rate_hz = -1.0;      ///< of its items: frames, or keyframes
  double age_ms = -1.0;       ///< of the frames when their poses were published, median
  double cpu_ms = -1.0;       ///< for one item
  double cpu_percent = -1.0;  ///< of one core
  double memory_mb = 0.0;
  int64_t queue = 0;                       ///< longest of its queues
  int64_t lost = 0;                        ///< messages since its start, and so are these two
  std::map<std::string, int64_t> lost_of;  ///< `lost` by channel; only those with losses
  int64_t repaired = 0;
  int64_t rejected = 0;
};

/// Traffic of a channel.
struct ChannelLoad {
  std::string name;  ///< on the wire, prefix included
  double rate_hz = 0.0;
  double kB_per_s = 0.0;
};

/// Rows ordered by robot, process, host and id; and by name.
struct BusLoad {
  std::vector<ProcessLoad> processes;
  std::vector<ChannelLoad> channels;
};

/// Two tables, with a line above each that names the columns.
std::string ToText(const BusLoad& load);
/// One line.
std::string ToJson(const BusLoad& load);

/// Listens to everything on a bus, under all prefixes, as a passive reader: no publisher waits for it. Messages are not
/// checked against a shared key.
class TopNode {
 public:
  /// The bus outlives it and has no other subscriptions.
  explicit TopNode(bus::Bus& bus);

  /// Returns the load since the last call, or the start; `now_s` is of the steady clock. Safe from any thread.
  /// Processes that have been silent for 30 s are left out.
  BusLoad Take(double now_s);

 private:
  struct LastStatus {
    ProcessLoad load;
    double items = 0.0;
    double cpu_s = 0.0;
    double heard_s = 0.0;
  };
  struct Traffic {
    int64_t messages = 0;
    int64_t bytes = 0;
  };

  void OnMessage(std::string_view wire_name, std::span<const uint8_t> bytes);
  void OnStatus(const std::string& robot, const status_t& status);
  void OnPose(std::string_view wire_name, std::span<const uint8_t> bytes);

  std::mutex mutex_;
  std::map<std::string, QuantileSketch> ages_ms_;  ///< by robot, since the last `Take`
  std::map<std::tuple<std::string, std::string, std::string, int64_t>, LastStatus> processes_;
  std::map<std::string, Traffic, std::less<>> channels_;
  double taken_s_ = 0.0;
};

}  // namespace plslam::launcher
