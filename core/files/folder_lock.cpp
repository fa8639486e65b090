// SPDX-License-Identifier: BSD-3-Clause
#include "core/files/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <vector>

namespace plslam {
namespace {

/// Returns the processes that have a lock on a file of this inode, from /proc/locks: "1: FLOCK ADVISORY WRITE PID
/// MAJOR:MINOR:INODE ...". The device is ignored: some file systems return another one from stat().
std::vector<pid_t> HoldersOf(ino_t inode) {
  std::vector<pid_t> holders;
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    std::istringstream words(line);
    std::string number, kind, advisory, access, file;
    pid_t pid = 0;
    if (!(words >> number >> kind >> advisory >> access >> pid >> file) || kind != "FLOCK") continue;
    if (file.ends_with(fmt::format(":{}", inode))) holders.push_back(pid);
  }
  return holders;
}

std::string CommandLine(pid_t pid) {
  constexpr size_t kMost = 200;
  std::ifstream file(fmt::format("/proc/{}/cmdline", pid));
  std::string text{std::istreambuf_iterator<char>(file), {}};
  while (!text.empty() && text.back() == '\0') text.pop_back();
  std::replace(text.begin(), text.end(), '\0', ' ');
  return text.size() > kMost ? text.substr(0, kMost) + "..." : text;
}

}  // namespace

FolderLock::FolderLock(const std::string& folder) : file_(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (file_ < 0) throw std::runtime_error(fmt::format("{}: cannot be opened: {}", folder, std::strerror(errno)));
  if (flock(file_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) return;
  struct stat status {};
  fstat(file_, &status);
  const std::vector<pid_t> holders = HoldersOf(status.st_ino);
  if (std::find(holders.begin(), holders.end(), getppid()) != holders.end()) return;
  close(file_);
  const std::string who = holders.empty()
                              ? "another process"
                              : fmt::format("process {} ({})", holders.front(), CommandLine(holders.front()));
  throw std::runtime_error(fmt::format(
      "{}: {} is writing its results there: give another folder, or wait until it has exited", folder, who));
}

FolderLock::~FolderLock() { close(file_); }

}  // namespace plslam
