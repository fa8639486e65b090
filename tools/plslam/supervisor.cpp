#include "tools/plslam/supervisor.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <fstream>

namespace plslam {

Supervisor::Supervisor(Options options) : options_(std::move(options)) {}

void Supervisor::Start(const std::string& name, const std::string& executable,
                       const std::vector<std::string>& arguments, Ending ending, int niceness) {
  std::filesystem::remove(LogOf(name));
  Child child;
  child.name = child.report.name = name;
  child.executable = executable;
  child.arguments = arguments;
  child.ending = ending;
  child.niceness = niceness;
  Spawn(&child);
  children_.push_back(std::move(child));
}

void Supervisor::Spawn(Child* child) {
  std::vector<std::string> arguments = child->arguments;
  if (child->report.restarts > 0 && options_.arguments_of_restart) {
    arguments = options_.arguments_of_restart(child->name, child->report.restarts, std::move(arguments));
  }
  child->process = std::make_unique<ChildProcess>(options_.bin / child->executable, arguments, LogOf(child->name),
                                                  child->niceness);
  child->start_at.reset();
  child->ready_again = false;
  child->report.exit_code.reset();
}

void Supervisor::SetReady(const std::string& name, TimePoint now) {
  for (Child& child : children_) {
    if (child.name != name || child.ready_again) continue;
    child.ready = child.ready_again = true;
    child.failed_starts = 0;
    if (child.report.restarts == 0) continue;
    const double took_s = std::chrono::duration<double>(now - child.ended_at).count();
    child.report.slowest_restart_s = std::max(child.report.slowest_restart_s, took_s);
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

/// A player that says what is wrong with its dataset would say so again.
bool Supervisor::MayRestart(const Child& child, const ChildExit& end) const {
  const bool crashed = child.ending == Ending::kRestart || end.code > 128;
  return crashed && child.ready && child.report.restarts < options_.max_restarts;
}

void Supervisor::HandleExit(Child* child, const ChildExit& end, TimePoint now) {
  const pid_t pid = child->process->pid();
  child->process.reset();
  child->ended_at = now;
  if (options_.on_exit) options_.on_exit(pid);
  child->report.cpu_s += end.cpu_s;
  child->report.peak_memory_mb = std::max(child->report.peak_memory_mb, end.peak_memory_mb);
  child->report.exit_code = end.code;
  if (stopping_since_ || child->interrupted || (child->ending == Ending::kMayEnd && end.code == 0)) return;
  if (MayRestart(*child, end)) {
    child->start_at = now + options_.first_pause * (1 << std::min(child->failed_starts, 10));
    ++child->failed_starts;
    return;
  }
  if (!failure_.empty()) return;
  const std::string last = LastLine(LogOf(child->name));
  failure_ = fmt::format("{} ended with exit code {}{}{}", child->name, end.code, last.empty() ? "" : ": ", last);
}

void Supervisor::Interrupt(const std::string& name) {
  for (Child& child : children_) {
    if (child.name != name) continue;
    child.interrupted = true;
    child.start_at.reset();
    if (child.process) child.process->Signal(SIGINT);
  }
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
