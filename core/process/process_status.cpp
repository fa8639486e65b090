// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_status.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "core/bus/run_loop.h"
#include "core/config/config.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/process/process_usage.h"
#include "core/run/process_names.h"
#include "plslam/status_t.hpp"
#include "plslam/warning_t.hpp"
#include "plslam_version.h"

namespace plslam::bus {
namespace {

/// `yaml`, or as many whole lines of it as fit.
std::string CutToFit(const std::string& yaml, size_t max_bytes) {
  static const std::string kCut = "# cut to fit into a message\n";
  if (yaml.size() <= max_bytes) return yaml;
  if (max_bytes < kCut.size()) return "";
  const size_t end = yaml.rfind('\n', max_bytes - kCut.size());
  return (end == std::string::npos ? "" : yaml.substr(0, end + 1)) + kCut;
}

void AddBusCounters(const BusCounters& c, std::map<std::string, double>* counters) {
  const std::pair<const char*, int64_t> rows[] = {
      {"bus.sent", c.sent},         {"bus.received", c.received},     {"bus.lost", c.lost},
      {"bus.repaired", c.repaired}, {"bus.resent", c.resent},         {"bus.rejected", c.rejected},
      {"bus.skipped", c.skipped},   {"bus.duplicates", c.duplicates}, {"bus.unproven", c.unproven}};
  for (const auto& [name, value] : rows) (*counters)[name] = static_cast<double>(value);
  for (const auto& [channel, n] : c.lost_of) (*counters)[kLostOf + channel] = static_cast<double>(n);
}

/// The line of bus.prefix in a configuration.
std::string PrefixLine(const std::string& configuration) {
  const size_t begin = configuration.find("\n  prefix:");
  return begin == std::string::npos ? "" : configuration.substr(begin, configuration.find('\n', begin + 1) - begin);
}

double NowUtc_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

constexpr const char* kStartedUtc = "started.utc_s";

/// Returns a counter that fits into an integer, whatever value was received.
double Counted(double value) {
  constexpr double kMost = 9007199254740992.0;  // 2^53
  return value > 0.0 ? std::min(value, kMost) : 0.0;
}

/// Maximum size of a status without its configuration, with room for two dozen counters and a reason.
constexpr size_t kStatusBytes = 900;
constexpr size_t kReasonBytes = 300;
/// Sentences with numbers differ each time: further ones are neither published nor logged.
constexpr size_t kMostOfOneCode = 10;
constexpr size_t kLongestWarning = 900;
// Statuses are published every five ticks.
constexpr std::chrono::milliseconds kTick(200);
constexpr int kTicks = 5;

}  // namespace

StatusPublisher::StatusPublisher(const std::string& process, const BusOptions& options, Bus& bus,
                                 std::function<void(const std::string& sentence)> on_older)
    : started_utc_s_(NowUtc_s()),
      process_(process),
      bus_(bus),
      namesakes_(bus.source()),
      on_older_(std::move(on_older)) {
  BusOptions shown = options;
  bus_configuration_ = ToYaml(kBusSection, shown);
  const auto limit = static_cast<size_t>(options.max_message_bytes);
  max_configuration_bytes_ = limit > kStatusBytes ? limit - kStatusBytes : 0;
  bus_.Every(kTick, [this] { OnTick(); });
  bus_.Subscribe<status_t>(kStatus, [this](const status_t& m) { OnStatus(m); });
}

void StatusPublisher::OnTick() {
  bool again = false;
  {
    const std::scoped_lock lock(mutex_);
    again = std::exchange(has_changed_, false);
  }
  if (++ticks_ % kTicks == 0 || again) Publish();
}

ProcessIdentity StatusPublisher::Identity() const {
  return {bus_.source(), HostName(), getpid(),
          std::chrono::duration<double>(std::chrono::steady_clock::now() - started_).count(), started_utc_s_};
}

/// The start of the other is computed from its status, as others compute ours.
void StatusPublisher::OnStatus(const status_t& other) {
  // Robots that share a map hear the statuses of its prefix, too.
  if (PrefixLine(other.configuration) != PrefixLine(bus_configuration_)) return;
  if (!on_older_ || other.process != process_ || other.state == process_state::kStopping ||
      other.state == process_state::kFailed)
    return;
  const ProcessIdentity namesake{SourceId(other.header.source), other.host, other.pid, other.uptime_s,
                                 CounterOf(other, kStartedUtc)};
  const std::string sentence = NamesakeWatch::Sentence(process_, namesake);
  switch (namesakes_.OnStatus(namesake, Identity(), NowS())) {
    case NamesakeWatch::Action::kNone:
      return;
    case NamesakeWatch::Action::kReply:
      return Publish();
    case NamesakeWatch::Action::kYield:
      if (on_older_) std::exchange(on_older_, nullptr)(sentence + "; stop it, or give --prefix to one of the two");
      return;
    case NamesakeWatch::Action::kReport:
      Warn("another_process",
           sentence +
               "; results are a mixture of both (replay a log beside the viewer alone, or with `plslam replay`)");
  }
}

bool StatusPublisher::Warn(const std::string& code, const std::string& sentence) {
  {
    const std::scoped_lock lock(mutex_);
    std::set<std::string>& sentences = warned_[code];
    if (sentences.size() == kMostOfOneCode || !sentences.insert(sentence).second) return false;
    newest_warning_ = sentence;
  }
  LogWarning("{}", sentence);
  warning_t message{};
  message.process = process_;
  message.code = code;
  message.sentence = sentence.substr(0, kLongestWarning);
  bus_.Publish(kWarning, std::move(message));
  return true;
}

void StatusPublisher::Publish() {
  const Usage usage = CurrentUsage();
  status_t status;
  status.header = {};
  status.process = process_;
  status.host = HostName();
  status.pid = getpid();
  status.version = PLSLAM_VERSION;
  status.cpu_s = usage.cpu_s;
  status.memory_mb = usage.memory_mb;
  status.uptime_s = Identity().uptime_s;
  std::map<std::string, double> all;
  AddBusCounters(bus_.counters(), &all);
  // For `plslam doctor`, which compares the clocks of hosts.
  all["clock.utc_s"] = NowUtc_s();
  all[kStartedUtc] = started_utc_s_;
  const std::string problems = bus_.Problems();
  const std::scoped_lock lock(mutex_);
  all.insert(counters_.begin(), counters_.end());
  for (const auto& [name, value] : all) status.counters.push_back({name, value});
  status.n_counters = static_cast<int32_t>(status.counters.size());
  status.state = state_;
  // A failure is stated alone: its cause was often published as a warning, too.
  status.reason = state_ == process_state::kFailed ? reason_ : Joined(Joined(reason_, problems), newest_warning_);
  status.reason.resize(std::min(status.reason.size(), kReasonBytes));
  status.configuration = CutToFit(bus_configuration_ + configuration_, max_configuration_bytes_);
  bus_.Publish(kStatus, std::move(status));
}

void StatusPublisher::SetState(const std::string& state, const std::string& reason) {
  {
    const std::scoped_lock lock(mutex_);
    if (state_ == state && reason_ == reason) return;
    state_ = state;
    reason_ = reason;
    has_changed_ = true;
  }
  Publish();
}

void StatusPublisher::SetReason(const std::string& reason) {
  {
    const std::scoped_lock lock(mutex_);
    if (reason_ == reason) return;
    reason_ = reason;
  }
  Publish();
}

std::string StatusPublisher::state() const {
  const std::scoped_lock lock(mutex_);
  return state_;
}

void StatusPublisher::SetConfiguration(const std::string& yaml) {
  const std::scoped_lock lock(mutex_);
  configuration_ = yaml;
}

void StatusPublisher::SetCounter(const std::string& name, double value) {
  const std::scoped_lock lock(mutex_);
  counters_[name] = value;
}

double StatusPublisher::counter(const std::string& name) const {
  const std::scoped_lock lock(mutex_);
  const auto found = counters_.find(name);
  return found == counters_.end() ? 0.0 : found->second;
}

double LongestQueueOf(const status_t& status) {
  double longest = 0.0;
  for (const counter_t& counter : status.counters) {
    if (counter.name.starts_with("queue.")) longest = std::max(longest, Counted(counter.value));
  }
  return longest;
}

double CounterOf(const status_t& status, const std::string& name) {
  for (const counter_t& counter : status.counters) {
    if (counter.name == name) return counter.value;
  }
  return 0.0;
}

int64_t CountOf(const status_t& status, const std::string& name) {
  return static_cast<int64_t>(Counted(CounterOf(status, name)));
}

}  // namespace plslam::bus
