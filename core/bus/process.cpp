#include "core/bus/process.h"

#include <unistd.h>

#include <chrono>
#include <mutex>

#include "core/bus/process_impl.h"
#include "core/bus/process_usage.h"
#include "plslam/status_t.hpp"

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
  const std::pair<const char*, int64_t> rows[] = {{"bus.sent", c.sent},       {"bus.received", c.received},
                                                  {"bus.lost", c.lost},       {"bus.repaired", c.repaired},
                                                  {"bus.resent", c.resent},   {"bus.rejected", c.rejected},
                                                  {"bus.skipped", c.skipped}, {"bus.duplicates", c.duplicates}};
  for (const auto& [name, value] : rows) (*counters)[name] = static_cast<double>(value);
}

/// What a status may take up beside its configuration, with room for two dozen counters and a reason.
constexpr size_t kStatusBytes = 900;

}  // namespace

Process::Process(const std::string& name, const BusOptions& options)
    : name_(name), impl_(std::make_unique<Impl>()), bus_(std::make_unique<Bus>(options, name)) {
  BusOptions shown = options;
  impl_->bus_configuration = ToYaml("bus", shown);
  const auto limit = static_cast<size_t>(options.max_message_bytes);
  impl_->max_configuration_bytes = limit > kStatusBytes ? limit - kStatusBytes : 0;
  impl_->publish = [this] { impl_->PublishStatus(name_, *bus_); };
  bus_->Every(std::chrono::milliseconds(1000), impl_->publish);
}

Process::~Process() = default;

void Process::Impl::PublishStatus(const std::string& name, Bus& bus) {
  status_t status;
  status.header = {};
  status.process = name;
  status.host = HostName();
  status.pid = getpid();
  status.version = PLSLAM_VERSION;
  const Usage usage = CurrentUsage();
  status.cpu_s = usage.cpu_s;
  status.memory_mb = usage.memory_mb;
  status.uptime_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
  std::map<std::string, double> all;
  AddBusCounters(bus.counters(), &all);
  // One publisher at a time, so that states arrive in the order in which they were set.
  const std::scoped_lock lock(mutex);
  all.insert(counters.begin(), counters.end());
  for (const auto& [counter_name, value] : all) status.counters.push_back({counter_name, value});
  status.n_counters = static_cast<int32_t>(status.counters.size());
  status.state = state;
  status.reason = reason.substr(0, 300);
  status.configuration = CutToFit(bus_configuration + configuration, max_configuration_bytes);
  bus.Publish(kStatus, std::move(status));
}

void Process::SetState(const std::string& state, const std::string& reason) {
  {
    const std::scoped_lock lock(impl_->mutex);
    impl_->state = state;
    impl_->reason = reason;
  }
  impl_->publish();
}

void Process::SetConfiguration(const std::string& yaml) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->configuration = yaml;
}

void Process::SetCounter(const std::string& name, double value) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->counters[name] = value;
}

void Process::Finish(int exit_code) {
  impl_->exit_code = exit_code;
  impl_->finished = true;
  bus_->Stop();
}

}  // namespace plslam::bus
