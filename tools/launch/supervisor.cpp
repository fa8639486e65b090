// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/supervisor.h"

#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <fstream>

#include "core/process/process_arguments.h"
#include "core/process/process_signals.h"

namespace plslam::launcher {
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
  const std::scoped_lock lock(mutex_);
  children_.push_back(std::move(child));
}

void Supervisor::Spawn(Child* child) {
  std::vector<std::string> arguments = child->arguments;
  if (child->report.restarts > 0 && options_.arguments_of_restart) {
    arguments = options_.arguments_of_restart(child->name, child->report.restarts, std::move(arguments));
  }
  child->start_at.reset();
  {
    const std::scoped_lock lock(mutex_);
    if (killed_) return;
    child->process = std::make_unique<ChildProcess>(options_.bin / child->executable, arguments, LogOf(child->name),
                                                    child->niceness, EndedBy::kLauncher);
  }
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
      std::unique_lock lock(mutex_);
      const auto end = child.process->Poll();
      lock.unlock();
      if (end) HandleExit(&child, *end, now);
    } else if (child.start_at && now >= *child.start_at && !stopping_since_) {
      ++child.report.restarts;
      Spawn(&child);
    }
  }
  if (!stopping_since_) return;
  for (Child& child : children_) ShortenDeadline(&child, now);
}

void Supervisor::ShortenDeadline(Child* child, TimePoint now) const {
  const auto waited = now - *stopping_since_;
  const bool writes = child->ending == Ending::kWritesAtTheEnd;
  const auto patience = writes ? options_.patience_with_writers : options_.patience;
  if (!child->process || child->signal == SIGKILL || waited <= patience) return;
  child->process->Signal(SIGKILL);
  child->signal = SIGKILL;
}

/// A player would report the same error of its dataset again, and a viewer its full disk.
bool Supervisor::MayRestart(const Child& child, const ChildExit& end) const {
  const bool crashed = end.signal != 0 || (child.ending == Ending::kRestart && child.ready);
  const bool has_namesake = end.signal == 0 && end.code == bus::kExitCodeOfNamesake;
  return !stopping_since_ && crashed && !has_namesake && child.report.restarts < options_.max_restarts;
}

/// Returns whether it ended as intended, or by our own signal.
bool Supervisor::ExitedNormally(const Child& child, const ChildExit& end) const {
  if (child.interrupted) return true;
  if (!stopping_since_) return child.ending == Ending::kMayEnd && end.code == 0;
  // A killed process has not written its results, unless it had not even begun. Other processes have nothing left to
  // write.
  const bool lacks_files = child.ending == Ending::kWritesAtTheEnd && child.ready;
  const bool killed = end.signal == SIGKILL || (end.signal != 0 && end.signal == child.signal);
  return end.code == 0 || (killed && !lacks_files);
}

void Supervisor::HandleExit(Child* child, const ChildExit& end, TimePoint now) {
  const pid_t pid = child->process->pid();
  {
    const std::scoped_lock lock(mutex_);
    child->process.reset();
  }
  child->ended_at = now;
  if (options_.on_exit) options_.on_exit(pid);
  child->report.cpu_s += end.cpu_s;
  child->report.peak_memory_mb = std::max(child->report.peak_memory_mb, end.peak_memory_mb);
  child->report.exit_code = end.code;
  child->report.exit_signal = end.signal;
  if (ExitedNormally(*child, end)) return;
  if (MayRestart(*child, end)) {
    child->start_at = now + options_.first_pause * (1 << std::min(child->failed_starts, 10));
    ++child->failed_starts;
    if (options_.on_restart) {
      options_.on_restart(child->name, ExitText(end), child->report.restarts + 1);
    }
    return;
  }
  Fail(*child, pid);
}

/// Only the first failure is reported: others often follow from it.
void Supervisor::Fail(const Child& child, pid_t pid) {
  if (!failure_.empty()) return;
  const int signal = child.report.exit_signal;
  const std::string how = signal != 0 && signal == child.signal
                              ? fmt::format("was killed ({}) while it stopped", bus::SignalName(signal))
                              : ExitText({.code = child.report.exit_code.value_or(0), .signal = signal});
  failure_ = child.name + " " + how;
  failed_ = child.name;
  failed_pid_ = pid;
}

/// The reason is in its log, as "vo: error: SENTENCE"; if that has no error, because the disk is full, in its last status,
/// which arrives a little later.
std::string Supervisor::failure() const {
  if (failure_.empty()) return failure_;
  std::string why = LastLine(LogOf(failed_));
  if (why.find("error: ") == std::string::npos && options_.last_word) {
    const std::string word = options_.last_word(failed_pid_);
    if (!word.empty()) why = word;
  }
  const std::string begin = failed_ + ": error: ";
  const size_t at = why.find(begin);
  if (at != std::string::npos) return fmt::format("{}: {}", failed_, why.substr(at + begin.size()));
  return why.empty() ? failure_ : failure_ + ": " + why;
}

void Supervisor::Interrupt(const std::string& name) {
  for (Child& child : children_) {
    if (child.name != name) continue;
    child.interrupted = true;
    child.start_at.reset();
    Order(&child);
  }
}

void Supervisor::Stop(TimePoint now) {
  if (stopping_since_) return;
  stopping_since_ = now;
  for (Child& child : children_) {
    // A crashed process that waits for its restart will not write its results.
    if (child.start_at && child.ending == Ending::kWritesAtTheEnd) Fail(child, -1);
    Order(&child);
  }
}

/// Once: a second order would end it at once.
void Supervisor::Order(Child* child) {
  if (!child->process || child->signal != 0) return;
  child->process->Signal(bus::kStopOrder);
  child->signal = bus::kStopOrder;
}

void Supervisor::KillAll() {
  const std::scoped_lock lock(mutex_);
  killed_ = true;
  for (const Child& child : children_) {
    if (child.process) child.process->Signal(SIGKILL);
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

std::string ExitText(const ChildExit& end) {
  return end.signal != 0 ? "was ended by " + bus::SignalName(end.signal)
                         : fmt::format("ended with exit code {}", end.code);
}

std::string LastLine(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string last;
  for (std::string line; std::getline(file, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

}  // namespace plslam::launcher
