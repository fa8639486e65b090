// SPDX-License-Identifier: BSD-3-Clause
#include "core/errors/error_text.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <optional>
#include <system_error>

namespace plslam {
namespace {

constexpr size_t kMaxShown = 60;

/// nullopt: none is set.
std::optional<uint64_t> Limit(__rlimit_resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

/// Of /proc/self/status or /proc/meminfo, in MB.
std::optional<double> Memory_MB(const char* file, const std::string& key) {
  std::ifstream in(file);
  for (std::string word; in >> word;) {
    double kib = 0.0;
    if (word == key && in >> kib) return kib * 1024e-6;
  }
  return std::nullopt;
}

std::string MemoryReason() {
  const double used_MB = Memory_MB("/proc/self/status", "VmSize:").value_or(0.0);
  if (const auto limit = Limit(RLIMIT_AS)) {
    return fmt::format("memory is not enough: this process has {:.0f} MB and may have {:.0f} MB (ulimit -v)", used_MB,
                       1e-6 * static_cast<double>(*limit));
  }
  return fmt::format("memory is not enough: {:.0f} MB of this host are free (free -m), this process has {:.0f} MB",
                     Memory_MB("/proc/meminfo", "MemAvailable:").value_or(0.0), used_MB);
}

std::string ThreadsReason() {
  const auto limit = Limit(RLIMIT_NPROC);
  return fmt::format(
      "{}: no more processes and threads may be started; this user may have {} (ulimit -u; a container may have "
      "less: pids.max of its cgroup)",
      std::strerror(EAGAIN), limit ? fmt::format("{}", *limit) : "any number");
}

/// An operation of std::filesystem, as its what() names it, in our words.
struct Operation {
  std::string_view theirs;
  std::string_view ours;
};
constexpr std::array<Operation, 8> kOperations = {{{"status", "cannot be read"},
                                                   {"symlink_status", "cannot be read"},
                                                   {"directory iterator", "cannot be read"},
                                                   {"cannot get file", "cannot be read"},
                                                   {"cannot check", "cannot be read"},
                                                   {"cannot create director", "cannot be made a folder"},
                                                   {"cannot remove", "cannot be removed"},
                                                   {"cannot rename", "cannot be renamed"}}};

/// "filesystem error: OPERATION: REASON [PATH]" is what the library says.
std::string FileSentence(const std::filesystem::filesystem_error& error) {
  static constexpr std::string_view kStart = "filesystem error: ";
  std::string_view what = error.what();
  if (what.starts_with(kStart)) what.remove_prefix(kStart.size());
  std::string operation(what.substr(0, what.find(": ")));
  for (const Operation& known : kOperations) {
    if (what.starts_with(known.theirs)) operation = known.ours;
  }
  return fmt::format("{}: {}: {}", error.path1().string(), operation,
                     ReasonOf(error.code().value(), error.path1().string()));
}

}  // namespace

std::string Shown(std::string_view text) {
  std::string shown;
  size_t cut = 0;
  for (const char c : text) {
    const bool plain = c >= ' ' && c <= '~';
    shown += plain ? std::string(1, c) : fmt::format("\\x{:02x}", static_cast<unsigned char>(c));
    if (shown.size() > kMaxShown) return shown.substr(0, cut) + "...";
    if (shown.size() + 3 <= kMaxShown) cut = shown.size();
  }
  return shown;
}

std::string ReasonOf(int error_number) {
  if (error_number == EAGAIN) return ThreadsReason();
  if (error_number == ENOMEM) return MemoryReason();
  std::string reason = std::strerror(error_number);
  if (error_number != EMFILE) return reason;
  const auto limit = Limit(RLIMIT_NOFILE);
  return fmt::format("{}; this process may have {} (ulimit -n)", reason, limit.value_or(0));
}

std::string ReasonOf(int error_number, const std::string& path) {
  std::string reason = ReasonOf(error_number);
  if (error_number != EACCES) return reason;
  std::filesystem::path above;
  const std::filesystem::path whole(path);
  for (auto part = whole.begin(); part != whole.end(); ++part) {
    if (!above.empty() && access(above.c_str(), X_OK) != 0 && errno == EACCES) {
      return fmt::format("{} (the folder {} is closed to this user)", reason, above.string());
    }
    above /= *part;
  }
  return reason;
}

std::string SentenceOf(const std::exception& error) {
  if (const auto* file = dynamic_cast<const std::filesystem::filesystem_error*>(&error)) return FileSentence(*file);
  if (IsOfMemory(error)) return MemoryReason();
  const auto* system = dynamic_cast<const std::system_error*>(&error);
  if (system != nullptr && system->code() == std::errc::resource_unavailable_try_again) return ReasonOf(EAGAIN);
  return error.what();
}

std::string Joined(const std::string& a, const std::string& b) {
  return a + (a.empty() || b.empty() ? "" : "; ") + b;
}

bool IsOfMemory(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return true;
  return std::string_view(error.what()).find("(-4:Insufficient memory)") != std::string_view::npos;
}

}  // namespace plslam
