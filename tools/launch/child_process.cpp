// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/child_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <stdexcept>

#include "core/errors/error_text.h"
#include "core/process/argument_vector.h"

namespace plslam::launcher {
namespace {

double Seconds(const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); }

/// Returns the peak memory of a running process; nullopt if it has just exited.
std::optional<double> PeakMemory_mb(pid_t pid) {
  std::ifstream status(fmt::format("/proc/{}/status", pid));
  for (std::string word; status >> word;) {
    double kib = 0.0;
    if (word == "VmHWM:" && status >> kib) return kib * 1024e-6;
  }
  return std::nullopt;
}

/// posix_spawn's two bundles of wishes, freed at the end of the scope.
struct SpawnWishes {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};

  SpawnWishes(const std::filesystem::path& log, EndedBy ended_by) {
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    posix_spawn_file_actions_adddup2(&files, 1, 2);
    posix_spawn_file_actions_addclosefrom_np(&files, 3);
    posix_spawnattr_init(&attributes);
    sigset_t blocked, defaults;
    sigemptyset(&blocked);
    sigemptyset(&defaults);
    for (const int signal : {SIGINT, SIGTERM, SIGUSR1, SIGPIPE}) sigaddset(&defaults, signal);
    if (ended_by == EndedBy::kLauncher) {
      for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&blocked, signal);
    }
    posix_spawnattr_setsigmask(&attributes, &blocked);
    posix_spawnattr_setsigdefault(&attributes, &defaults);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnWishes() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnWishes(const SpawnWishes&) = delete;
  SpawnWishes& operator=(const SpawnWishes&) = delete;
};

/// The error may concern the program or its log file: posix_spawn does not distinguish them.
std::string WhyNotStarted(const std::filesystem::path& program, const std::filesystem::path& log, int error) {
  const int fd = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (fd < 0) {
    return fmt::format("{} cannot be started because its log {} cannot be written: {}", program.string(),
                       log.string(), ReasonOf(errno));
  }
  close(fd);
  return fmt::format("{} cannot be started: {}", program.string(), ReasonOf(error));
}

}  // namespace

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           const std::filesystem::path& log, int niceness, EndedBy ended_by) {
  std::vector<std::string> words = {program.string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const std::vector<char*> argv = ArgumentVector(words);
  const SpawnWishes wishes(log, ended_by);
  const int error = posix_spawn(&pid_, program.c_str(), &wishes.files, &wishes.attributes, argv.data(), environ);
  if (error != 0) {
    pid_ = -1;
    throw std::runtime_error(WhyNotStarted(program, log, error));
  }
  // Set before the process has threads, which would not inherit it later. If it is refused, the process has our
  // priority.
  if (niceness != 0) setpriority(PRIO_PROCESS, static_cast<id_t>(pid_), getpriority(PRIO_PROCESS, 0) + niceness);
}

ChildProcess::~ChildProcess() {
  if (pid_ < 0 || Poll()) return;
  Signal(SIGKILL);
  Wait(0);
}

std::optional<ChildExit> ChildProcess::Poll() { return exit_ ? exit_ : Wait(WNOHANG); }

std::optional<ChildExit> ChildProcess::Wait(int options) {
  int status = 0;
  rusage used{};
  if (wait4(pid_, &status, options, &used) != pid_) {
    if (const auto peak_mb = PeakMemory_mb(pid_)) peak_memory_mb_ = peak_mb;
    return std::nullopt;
  }
  // Its ru_maxrss includes our own memory at its start.
  const double peak_mb = peak_memory_mb_.value_or(static_cast<double>(used.ru_maxrss) * 1024e-6);
  const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  exit_ = ChildExit{signal == 0 ? WEXITSTATUS(status) : 128 + signal, signal,
                    Seconds(used.ru_utime) + Seconds(used.ru_stime), peak_mb};
  return exit_;
}

void ChildProcess::Signal(int signal) const {
  if (!exit_) kill(pid_, signal);
}

}  // namespace plslam::launcher
