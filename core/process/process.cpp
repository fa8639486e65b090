// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"

#include <fmt/format.h>
#include <unistd.h>
#include <cstdio>

#include "core/errors/standard_streams.h"
#include "core/process/process_arguments.h"
#include "core/process/process_impl.h"
#include "core/run/process_names.h"

namespace plslam::bus {

Process::Process(const std::string& name, const BusOptions& options)
    : name_(name),
      bus_(std::make_unique<Bus>(options, name)),
      impl_(std::make_unique<Impl>(name, options, *bus_, [this](const std::string& sentence) { Yield(sentence); })) {}

Process::~Process() = default;

bool Process::has_launcher() const { return impl_->has_launcher; }

void Process::SetState(const std::string& state, const std::string& reason) {
  impl_->status.SetState(state, reason);
  impl_->terminal.ReportState(state, reason);
}

void Process::SetReason(const std::string& reason) { impl_->status.SetReason(reason); }

bool Process::Warn(const std::string& code, const std::string& sentence) {
  return impl_->status.Warn(code, sentence);
}

void Process::SetConfiguration(const std::string& yaml) { impl_->status.SetConfiguration(yaml); }

void Process::SetCounter(const std::string& name, double value) { impl_->status.SetCounter(name, value); }

void Process::Yield(const std::string& sentence) {
  PrintError(fmt::format("{}: error: {}", name_, sentence));
  SetState(process_state::kFailed, sentence);
  impl_->has_yielded = true;
  Finish(impl_->exit_code_of_namesake);
}

void Process::Finish(int exit_code) {
  impl_->exit_code = exit_code;
  impl_->finished = true;
  bus_->Stop();
}

void ProcessTerminal::Begin(const std::string& program) {
  const std::scoped_lock lock(mutex_);
  program_ = program;
}

void ProcessTerminal::PrintLine(const std::string& words) {
  const std::scoped_lock lock(mutex_);
  Print(words);
}

// A state has many reasons in succession (the awaited frame, for example): the first is enough.
void ProcessTerminal::ReportState(const std::string& state, const std::string& reason) {
  const std::scoped_lock lock(mutex_);
  const bool news = state != state_ || (reason_.empty() && !reason.empty());
  const bool printed_elsewhere =
      state == process_state::kReady || state == process_state::kStopping || state == process_state::kFailed;
  if (state != state_) reason_.clear();
  if (!reason.empty()) reason_ = reason;
  state_ = state;
  if (news && !printed_elsewhere) Print(reason.empty() ? state : fmt::format("{}, {}", state, reason));
}

void ProcessTerminal::Print(const std::string& words) const {
  if (program_.empty()) return;
  // Overwrites a progress line of the same process. A closed terminal is no error.
  const char* begin = isatty(STDERR_FILENO) == 1 ? "\r\x1b[K" : "";
  std::fputs(fmt::format("{}{}: {}\n", begin, program_, words).c_str(), stderr);
}

}  // namespace plslam::bus
