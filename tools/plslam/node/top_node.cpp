// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/top_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include <nlohmann/json.hpp>

#include "core/bus/run_loop.h"
#include "core/bus/transport/wire.h"
#include "core/process/process_status.h"
#include "lcmtypes/message_layout.h"
#include "plslam/counter_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"

namespace plslam::launcher {
namespace {

// More are invented.
constexpr size_t kMaxRows = 4096;
constexpr double kGone_s = 30.0;
constexpr double kPercent = 100.0;
constexpr double kMsPerS = 1000.0;
constexpr double kBytesPerKb = 1000.0;

/// Returns the progress of a process by the counter of its items.
double ItemsOf(const status_t& status) {
  for (const char* name : {"frames", "frames.sent", "map.keyframes", "loop.keyframes"}) {
    const double count = bus::CounterOf(status, name);
    if (count > 0.0) return count;
  }
  return 0.0;
}

std::string Figure(double value, int decimals) {
  return value < 0.0 || !std::isfinite(value) ? "-" : fmt::format("{:.{}f}", value, decimals);
}

// For example a file name of another system must not move the cursor.
std::string Printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }, '?');
  return text;
}

/// Messages that had to be requested again: "lost of STEREO_FRAME: vo 12, viewer 3". Empty if there are none.
std::string LinksToText(const BusLoad& load) {
  std::map<std::string, std::string> readers;
  for (const ProcessLoad& p : load.processes) {
    for (const auto& [channel, n] : p.lost_of) {
      std::string& text = readers[channel];
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", p.robot + p.process, n);
    }
  }
  std::string text;
  for (const auto& [channel, names] : readers) {
    text += fmt::format("lost of {}: {}\n", Printable(channel), Printable(names));
  }
  return text.empty() ? "" : "\n" + text;
}

std::string OrDash(const std::string& text) { return text.empty() ? "-" : Printable(text); }

}  // namespace

TopNode::TopNode(bus::Bus& bus) : taken_s_(bus::NowS()) {
  bus.SubscribeRest(
      [this](std::string_view wire_name, std::span<const uint8_t> bytes) { OnMessage(wire_name, bytes); });
}

void TopNode::OnMessage(std::string_view wire_name, std::span<const uint8_t> bytes) {
  {
    const std::lock_guard lock(mutex_);
    auto channel = channels_.find(wire_name);
    if (channel == channels_.end() && channels_.size() < kMaxRows)
      channel = channels_.emplace(std::string(wire_name), Traffic{}).first;
    if (channel != channels_.end()) {
      ++channel->second.messages;
      channel->second.bytes += static_cast<int64_t>(bytes.size());
    }
  }
  if (wire_name.ends_with(bus::kPose.name)) OnPose(wire_name, bytes);
  if (!wire_name.ends_with(bus::kStatus.name)) return;
  static const MessageLayout* const kLayout = FindMessageLayout(bus::kStatus.type);
  if (!bus::MessageLength(*kLayout, bytes)) return;
  const std::optional<status_t> status = bus::Decoded<status_t>(bytes);
  if (status) OnStatus(std::string(wire_name.substr(0, wire_name.size() - bus::kStatus.name.size())), *status);
}

void TopNode::OnPose(std::string_view wire_name, std::span<const uint8_t> bytes) {
  static const MessageLayout* const kLayout = FindMessageLayout(bus::kPose.type);
  if (!bus::MessageLength(*kLayout, bytes)) return;
  const std::optional<pose_t> pose = bus::Decoded<pose_t>(bytes);
  if (!pose || !std::isfinite(pose->age_ms)) return;
  const std::lock_guard lock(mutex_);
  const std::string robot(wire_name.substr(0, wire_name.size() - bus::kPose.name.size()));
  if (ages_ms_.size() >= kMaxRows && !ages_ms_.contains(robot)) return;
  ages_ms_[robot].Add(pose->age_ms);
}

void TopNode::OnStatus(const std::string& robot, const status_t& status) {
  const std::lock_guard lock(mutex_);
  const std::tuple key(robot, status.process, status.host, status.pid);
  if (processes_.size() >= kMaxRows && !processes_.contains(key)) return;
  LastStatus& last = processes_[key];
  const bool is_first = last.load.process.empty();
  ProcessLoad& load = last.load;
  const double items = ItemsOf(status);
  const double passed_s = status.uptime_s - load.uptime_s;
  // A status is also sent at a change of state: rates over shorter times are inaccurate.
  constexpr double kShortest_s = 0.5;
  if (is_first) {
    load.robot = robot;
    load.process = status.process;
    load.host = status.host;
    load.pid = status.pid;
  } else if (passed_s >= kShortest_s) {
    const double cpu_s = status.cpu_s - last.cpu_s;
    const double done = std::max(0.0, items - last.items);
    load.cpu_percent = kPercent * cpu_s / passed_s;
    load.rate_hz = done / passed_s;
    load.cpu_ms = done > 0.0 ? kMsPerS * cpu_s / done : -1.0;
  }
  if (is_first || passed_s >= kShortest_s || passed_s < 0.0) {
    last.items = items;
    last.cpu_s = status.cpu_s;
    load.uptime_s = status.uptime_s;
  }
  const auto count = [&](const char* name) { return bus::CountOf(status, name); };
  load.state = status.state;
  load.reason = status.reason;
  load.memory_mb = status.memory_mb;
  load.lost = count("bus.lost");
  load.lost_of.clear();
  for (const counter_t& counter : status.counters) {
    if (!counter.name.starts_with(bus::kLostOf)) continue;
    const std::string channel = counter.name.substr(std::string_view(bus::kLostOf).size());
    load.lost_of[channel] = bus::CountOf(status, counter.name);
  }
  load.repaired = count("bus.repaired");
  load.rejected = count("bus.rejected");
  load.queue = static_cast<int64_t>(bus::LongestQueueOf(status));
  last.heard_s = bus::NowS();
}

BusLoad TopNode::Take(double now_s) {
  const std::lock_guard lock(mutex_);
  const double passed_s = std::max(1e-3, now_s - std::exchange(taken_s_, now_s));
  BusLoad result;
  std::erase_if(processes_, [&](const auto& row) { return now_s - row.second.heard_s > kGone_s; });
  for (auto& [key, last] : processes_) {
    last.load.heard_s_ago = std::max(0.0, now_s - last.heard_s);
    const auto ages = last.load.process == bus::kPose.publisher ? ages_ms_.find(last.load.robot) : ages_ms_.end();
    last.load.age_ms = ages == ages_ms_.end() ? -1.0 : ages->second.Quantile(0.5);
    result.processes.push_back(last.load);
  }
  ages_ms_.clear();
  for (auto& [name, traffic] : channels_) {
    result.channels.push_back({name, static_cast<double>(traffic.messages) / passed_s,
                               static_cast<double>(traffic.bytes) / kBytesPerKb / passed_s});
    traffic = {};
  }
  return result;
}

std::string ToText(const BusLoad& load) {
  std::string text =
      fmt::format("{:<10} {:<9} {:<12} {:>7} {:<9} {:>6} {:>7} {:>6} {:>6} {:>6} {:>6} {:>6} {:>8} {:>8}  {}\n",
                  "robot", "process", "host", "pid", "state", "heard", "/s", "age ms", "CPU ms", "CPU %", "MB",
                  "queue", "lost", "repaired", "says");
  for (const ProcessLoad& p : load.processes) {
    text +=
        fmt::format("{:<10} {:<9} {:<12} {:>7} {:<9} {:>6} {:>7} {:>6} {:>6} {:>6} {:>6.0f} {:>6} {:>8} {:>8}  {}\n",
                    OrDash(p.robot), OrDash(p.process), OrDash(p.host), p.pid, OrDash(p.state),
                    Figure(p.heard_s_ago, 1), Figure(p.rate_hz, 1), Figure(p.age_ms, 1), Figure(p.cpu_ms, 1),
                    Figure(p.cpu_percent, 0), p.memory_mb, p.queue, p.lost, p.repaired, Printable(p.reason));
  }
  text += LinksToText(load);
  text += fmt::format("\n{:<32} {:>9} {:>10}\n", "channel", "Hz", "kB/s");
  for (const ChannelLoad& c : load.channels)
    text += fmt::format("{:<32} {:>9.1f} {:>10.1f}\n", Printable(c.name), c.rate_hz, c.kB_per_s);
  return text;
}

std::string ToJson(const BusLoad& load) {
  const auto figure = [](double value) { return value < 0.0 ? nlohmann::json() : nlohmann::json(value); };
  nlohmann::json processes = nlohmann::json::array();
  for (const ProcessLoad& p : load.processes) {
    processes.push_back({{"robot", p.robot},
                         {"process", p.process},
                         {"host", p.host},
                         {"pid", p.pid},
                         {"state", p.state},
                         {"reason", p.reason},
                         {"heard_s_ago", p.heard_s_ago},
                         {"uptime_s", p.uptime_s},
                         {"rate_hz", figure(p.rate_hz)},
                         {"age_ms", figure(p.age_ms)},
                         {"cpu_ms", figure(p.cpu_ms)},
                         {"cpu_percent", figure(p.cpu_percent)},
                         {"memory_mb", p.memory_mb},
                         {"queue", p.queue},
                         {"lost", p.lost},
                         {"lost_of", p.lost_of},
                         {"repaired", p.repaired},
                         {"rejected", p.rejected}});
  }
  nlohmann::json channels = nlohmann::json::array();
  for (const ChannelLoad& c : load.channels)
    channels.push_back({{"name", c.name}, {"rate_hz", c.rate_hz}, {"kB_per_s", c.kB_per_s}});
  const nlohmann::json all = {{"processes", processes}, {"channels", channels}};
  // Names from the wire may be no UTF-8.
  return all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace plslam::launcher
