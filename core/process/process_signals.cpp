// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_signals.h"

#include <fmt/format.h>
#include <poll.h>
#include <pthread.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <stdexcept>
#include <utility>

#include "core/errors/error_text.h"
#include "core/errors/log.h"

namespace plslam::bus {
namespace {

/// Shorter than the time between two key strokes.
constexpr std::chrono::milliseconds kSameMoment{50};
/// Time to finish writing files after the launcher has exited; no other process would end one that hangs.
constexpr unsigned kGraceWithoutLauncher_s = 60;

bool IsIgnored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

sigset_t SignalsToWatch(bool launched) {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM}) sigaddset(&signals, signal);
  if (launched || !IsIgnored(SIGHUP)) sigaddset(&signals, SIGHUP);
  if (launched) sigaddset(&signals, kStopOrder);
  return signals;
}

}  // namespace

std::string SignalName(int signal) {
  const char* name = sigabbrev_np(signal);
  return name != nullptr ? fmt::format("SIG{}", name) : fmt::format("signal {}", signal);
}

SignalWatcher::SignalWatcher(std::function<void(const std::string&)> on_stop, pid_t launcher,
                             std::function<void()> before_the_end)
    : on_stop_(std::move(on_stop)), launcher_(launcher), before_the_end_(std::move(before_the_end)) {
  const sigset_t signals = SignalsToWatch(launcher_ != 0);
  pthread_sigmask(SIG_BLOCK, &signals, &previous_mask_);
  signal_fd_ = signalfd(-1, &signals, SFD_CLOEXEC);
  stop_fd_ = eventfd(0, EFD_CLOEXEC);
  if (signal_fd_ < 0 || stop_fd_ < 0) throw std::runtime_error("signals cannot be handled: " + ReasonOf(errno));
  thread_ = std::thread([this] { Watch(); });
}

SignalWatcher::~SignalWatcher() {
  const uint64_t one = 1;
  while (write(stop_fd_, &one, sizeof one) < 0 && errno == EINTR) {
  }
  thread_.join();
  if (stopping_) TakePending();
  close(signal_fd_);
  close(stop_fd_);
  pthread_sigmask(SIG_SETMASK, &previous_mask_, nullptr);
}

/// A second signal of the same moment would end the process when the mask is restored.
void SignalWatcher::TakePending() const {
  pollfd wait{signal_fd_, POLLIN, 0};
  signalfd_siginfo info{};
  while (poll(&wait, 1, 0) > 0 && read(signal_fd_, &info, sizeof info) == sizeof info) {
  }
}

void SignalWatcher::Watch() {
  while (true) {
    pollfd waits[] = {{signal_fd_, POLLIN, 0}, {stop_fd_, POLLIN, 0}};
    while (poll(waits, 2, -1) < 0 && errno == EINTR) {
    }
    if (waits[1].revents != 0) return;
    signalfd_siginfo info{};
    if (read(signal_fd_, &info, sizeof info) != sizeof info) return;
    Take(static_cast<int>(info.ssi_signo));
  }
}

void SignalWatcher::Take(int signal) {
  if (launcher_ != 0 && signal != kStopOrder) {
    if (getppid() == launcher_) {
      LogInfo("{}: ignored, because the process that started this one ends it", SignalName(signal));
      return;
    }
    alarm(kGraceWithoutLauncher_s);
    if (stopping_) return;
  }
  const auto now = Clock::now();
  const auto since_last = now - std::exchange(last_at_, now);
  if (!std::exchange(stopping_, true)) return on_stop_(SignalName(signal));
  if (signal == SIGHUP || since_last < kSameMoment) return;
  EndAtOnce(signal);
}

void SignalWatcher::EndAtOnce(int signal) const {
  if (before_the_end_) before_the_end_();
  _exit(128 + signal);
}

}  // namespace plslam::bus
