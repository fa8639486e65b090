// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/process_log.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/run/lag.h"

namespace plslam::viewer {
namespace {

constexpr size_t kMaxProcesses = 16;
constexpr size_t kMaxCounters = 32;
constexpr size_t kMaxSamples = 600;
constexpr std::array kBusCounters{"bus.lost", "bus.repaired", "bus.resent", "bus.rejected", "bus.skipped"};

bool IsShown(const std::string& counter) {
  return counter.rfind("queue.", 0) == 0 ||
         std::find(kBusCounters.begin(), kBusCounters.end(), counter) != kBusCounters.end();
}

}  // namespace

void ProcessLog::Add(const ProcessSample& sample) {
  for (const double value : {sample.t_s, sample.uptime_s, sample.cpu_s, sample.memory_mb}) {
    if (!std::isfinite(value)) return;
  }
  if (processes_.empty()) first_t_s_ = sample.t_s;
  if (!processes_.contains(sample.process) && processes_.size() >= kMaxProcesses) return;
  Series& series = processes_[sample.process];
  const bool changed = series.state != sample.state;
  series.state = sample.state;
  series.heard_s = sample.t_s - first_t_s_;
  series.queue = std::isfinite(sample.queue) ? sample.queue : 0.0;
  series.lag_frames = sample.lag_frames;
  series.sent_frames = sample.sent_frames;
  if (series.heard > 0 && series.pid != sample.pid) ++series.restarts;
  series.pid = sample.pid;
  if (series.heard++ % series.every != 0 && !changed) return;
  ProcessSample relative = sample;
  relative.t_s -= first_t_s_;
  Append(relative, series);
  if (series.t_s.size() > kMaxSamples) Halve(series);
}

void ProcessLog::Append(const ProcessSample& sample, Series& series) {
  series.t_s.push_back(static_cast<float>(sample.t_s));
  series.uptime_s.push_back(static_cast<float>(sample.uptime_s));
  series.frame.push_back(Clamp32(sample.frame_id.value));
  series.cpu_s.push_back(static_cast<float>(sample.cpu_s));
  series.memory_mb.push_back(static_cast<float>(sample.memory_mb));
  for (const auto& [name, value] : sample.counters) {
    if (!IsShown(name) || !std::isfinite(value)) continue;
    if (!series.counters.contains(name) && series.counters.size() >= kMaxCounters) continue;
    std::vector<float>& values = series.counters[name];
    values.resize(series.t_s.size(), std::numeric_limits<float>::quiet_NaN());
    values.back() = static_cast<float>(value);
  }
  for (auto& [name, values] : series.counters)
    values.resize(series.t_s.size(), std::numeric_limits<float>::quiet_NaN());
}

void ProcessLog::Halve(Series& series) {
  KeepEverySecond(series.t_s);
  KeepEverySecond(series.uptime_s);
  KeepEverySecond(series.frame);
  KeepEverySecond(series.cpu_s);
  KeepEverySecond(series.memory_mb);
  for (auto& [name, values] : series.counters) KeepEverySecond(values);
  series.every *= 2;
}

std::vector<ReportProcess> ProcessLog::Processes() const {
  std::vector<ReportProcess> processes;
  double now_s = 0.0;
  int64_t sent_frames = 0;
  for (const auto& [name, series] : processes_) {
    now_s = std::max(now_s, series.heard_s);
    sent_frames = std::max(sent_frames, series.sent_frames);
  }
  for (const auto& [name, series] : processes_) {
    const double silent_s = now_s - series.heard_s;
    const Pace pace = PaceOf(series.state, silent_s, series.queue);
    // Frames sent during the silence count as unprocessed.
    const bool is_silent = pace == Pace::kSilent || pace == Pace::kGone;
    const int64_t more_frames = series.lag_frames >= 0 && is_silent ? sent_frames - series.sent_frames : 0;
    ReportProcess process{.name = name,
                          .state = series.state,
                          .pace = std::string(PaceName(pace)),
                          .silent_s = silent_s,
                          .queue = series.queue,
                          .lag_frames = series.lag_frames + more_frames,
                          .restarts = series.restarts,
                          .table = {}};
    process.table = {{"t_s", 1, series.t_s},
                     {"uptime_s", 1, series.uptime_s},
                     {"frame", 1, series.frame},
                     {"cpu_s", 1, series.cpu_s},
                     {"memory_mb", 1, series.memory_mb}};
    for (const auto& [counter, values] : series.counters) process.table.push_back({counter, 1, values});
    processes.push_back(std::move(process));
  }
  return processes;
}

}  // namespace plslam::viewer
