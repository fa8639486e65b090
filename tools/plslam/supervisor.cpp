#include "tools/plslam/supervisor.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <fstream>

namespace plslam {

Supervisor::Supervisor(Options options) : options_(std::move(options)) {}

void Supervisor::Start(const std::string& name, const std::string& executable,
                       const std::vector<std::string>& arguments, Ending ending) {
  std::filesystem::remove(LogOf(name));
  Child child{name, executable, arguments, ending, false, nullptr, std::nullopt, {}};
  child.report.name = name;
  Spawn(&child);
  children_.push_back(std::move(child));
}

void Supervisor::Spawn(Child* child) {
  child->process =
      std::make_unique<ChildProcess>(options_.bin / child->executable, child->arguments, LogOf(child->name));
  child->start_at.reset();
  child->report.exit_code.reset();
}

void Supervisor::SetReady(const std::string& name) {
  for (Child& child : children_) {
    if (child.name == name) child.ready = true;
  }
}

pid_t Supervisor::pid(const std::string& name) const {
  for (const Child& child : children_) {
    if (child.name == name && child.process) return child.process->pid();
  }
  return -1;
}

void Supervisor::Tick(TimePoint now) {
  for (Child& child : children_) {
    if (child.process) {
      if (const auto end = child.process->Poll()) HandleExit(&child, *end, now);
    } else if (child.start_at && now >= *child.start_at && !stopping_since_) {
      ++child.report.restarts;
      Spawn(&child);
    }
  }
  if (!stopping_since_ || stopped()) return;
  const auto waited = now - *stopping_since_;
  if (signals_sent_ == 1 && waited > options_.patience) SignalAll(SIGTERM);
  if (signals_sent_ == 2 && waited > 2 * options_.patience) SignalAll(SIGKILL);
}

void Supervisor::HandleExit(Child* child, const ChildExit& end, TimePoint now) {
  child->process.reset();
  child->report.cpu_s += end.cpu_s;
  child->report.peak_memory_mb = std::max(child->report.peak_memory_mb, end.peak_memory_mb);
  child->report.exit_code = end.code;
  if (stopping_since_ || (child->ending == Ending::kMayEnd && end.code == 0)) return;
  if (child->ending == Ending::kRestart && child->ready && child->report.restarts < options_.max_restarts) {
    child->start_at = now + options_.first_pause * (1 << std::min(child->report.restarts, 10));
    return;
  }
  if (!failure_.empty()) return;
  const std::string last = LastLine(LogOf(child->name));
  failure_ = fmt::format("{} ended with exit code {}{}{}", child->name, end.code, last.empty() ? "" : ": ", last);
}

void Supervisor::Stop(TimePoint now) {
  if (stopping_since_) return;
  stopping_since_ = now;
  SignalAll(SIGINT);
}

void Supervisor::SignalAll(int signal) {
  ++signals_sent_;
  for (const Child& child : children_) {
    if (child.process) child.process->Signal(signal);
  }
}

bool Supervisor::stopped() const {
  return std::none_of(children_.begin(), children_.end(), [](const Child& c) { return c.process != nullptr; });
}

std::vector<ProcessReport> Supervisor::reports() const {
  std::vector<ProcessReport> reports;
  for (const Child& child : children_) reports.push_back(child.report);
  return reports;
}

int Supervisor::restarts() const {
  int sum = 0;
  for (const Child& child : children_) sum += child.report.restarts;
  return sum;
}

std::string LastLine(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace plslam
