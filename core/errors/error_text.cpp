// SPDX-License-Identifier: BSD-3-Clause
#include "core/errors/error_text.h"

#include <unistd.h>

#include <sys/resource.h>
#include <sys/stat.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <new>
#include <optional>
#include <stdexcept>
#include <system_error>

#include <fmt/format.h>

namespace plslam {
namespace {

/// Cuts the first line off `text`.
std::string_view TakeLine(std::string_view& text) {
  const size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

bool IsIndentedByTab(std::string_view line) {
  const size_t first = line.find_first_not_of(" \t");
  return first != std::string_view::npos && line[first] != '#' && line.substr(0, first).find('\t') != line.npos;
}

}  // namespace

namespace {

/// The parser takes a line without a key for the beginning of the next line's key, and complains about that line.
constexpr std::string_view kIllegalValue = "illegal map value";

bool HasKey(std::string_view line) {
  return line.find(": ") != line.npos || line.find_last_not_of(" \r") == line.rfind(':');
}

}  // namespace

std::string YamlComplaint(const std::string& name, std::string_view text, int line, const std::string& what) {
  if (text.find('\0') != std::string_view::npos) return name + ": is not YAML, but binary: " + Shown(text);
  std::string_view rest = text, culprit, before;
  int before_line = 0;
  for (int i = 0; i <= line && !rest.empty(); ++i) {
    const size_t first = culprit.find_first_not_of(" \t\r");
    if (first != culprit.npos && culprit[first] != '#') {
      before = culprit;
      before_line = i;
    }
    culprit = TakeLine(rest);
    if (IsIndentedByTab(culprit)) {
      return fmt::format("{}:{}: is indented by a tab; YAML requires spaces", name, i + 1);
    }
  }
  if (line < 0) return fmt::format("{}: not valid YAML: {}", name, what);
  if (what.find(kIllegalValue) != what.npos && before_line > 0 && !HasKey(before)) {
    return fmt::format("{}:{}: not valid YAML: no `key: value` ('{}')", name, before_line, Shown(before));
  }
  return fmt::format("{}:{}: not valid YAML: {} ('{}')", name, line + 1, what, Shown(culprit));
}

namespace {

constexpr size_t kMaxShown = 60;

/// Returns nullopt if none is set.
std::optional<uint64_t> Limit(__rlimit_resource resource) {
  rlimit limit{};
  if (getrlimit(resource, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
  return limit.rlim_cur;
}

/// Returns a value of /proc/self/status or /proc/meminfo, in MB.
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
    return fmt::format("not enough memory: this process uses {:.0f} MB and may use {:.0f} MB (ulimit -v)", used_MB,
                       1e-6 * static_cast<double>(*limit));
  }
  return fmt::format("not enough memory: {:.0f} MB of this host are free (free -m), this process uses {:.0f} MB",
                     Memory_MB("/proc/meminfo", "MemAvailable:").value_or(0.0), used_MB);
}

std::string ThreadsReason() {
  const auto limit = Limit(RLIMIT_NPROC);
  return fmt::format(
      "{}: no more processes or threads can be started; the limit of this user is {} (ulimit -u; a container may "
      "have a lower one: pids.max of its cgroup)",
      std::strerror(EAGAIN), limit ? fmt::format("{}", *limit) : "unlimited");
}

/// An operation of std::filesystem as named in its what(), and our wording.
struct Operation {
  std::string_view theirs;
  std::string_view ours;
};
constexpr std::array<Operation, 8> kOperations = {{{"status", "cannot be read"},
                                                   {"symlink_status", "cannot be read"},
                                                   {"directory iterator", "cannot be read"},
                                                   {"cannot get file", "cannot be read"},
                                                   {"cannot check", "cannot be read"},
                                                   {"cannot create director", "the folder cannot be created"},
                                                   {"cannot remove", "cannot be removed"},
                                                   {"cannot rename", "cannot be renamed"}}};

/// "filesystem error: OPERATION: REASON [PATH]" is the sentence of the library.
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

std::string InHtml(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += c;
    }
  }
  return escaped;
}

std::string ReasonOf(int error_number) {
  if (error_number == EAGAIN) return ThreadsReason();
  if (error_number == ENOMEM) return MemoryReason();
  std::string reason = std::strerror(error_number);
  if (error_number != EMFILE) return reason;
  const auto limit = Limit(RLIMIT_NOFILE);
  return fmt::format("{}; this process may open {} (ulimit -n)", reason, limit.value_or(0));
}

std::string ReasonOf(int error_number, const std::string& path) {
  std::string reason = ReasonOf(error_number);
  if (error_number != EACCES) return reason;
  std::filesystem::path above;
  const std::filesystem::path whole(path);
  for (auto part = whole.begin(); part != whole.end(); ++part) {
    if (!above.empty() && access(above.c_str(), X_OK) != 0 && errno == EACCES) {
      return fmt::format("{} (this user cannot access the folder {})", reason, above.string());
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
  static constexpr std::string_view kPrinted = "cannot write to file: ";  // the words of fmt::print
  const std::string what = error.what();
  return what.starts_with(kPrinted) ? "standard output: cannot be written: " + what.substr(kPrinted.size()) : what;
}

std::string Joined(const std::string& a, const std::string& b) {
  return a + (a.empty() || b.empty() ? "" : "; ") + b;
}

bool IsOfMemory(const std::exception& error) {
  if (dynamic_cast<const std::bad_alloc*>(&error) != nullptr) return true;
  return std::string_view(error.what()).find("(-4:Insufficient memory)") != std::string_view::npos;
}

std::string WhyUnreadable(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return "cannot be read: " + ReasonOf(errno, path);
  if (S_ISDIR(status.st_mode)) return "cannot be read: it is a folder, not a file";
  // Not opened to see: a pipe would have lost its reader when it is closed again.
  if (access(path.c_str(), R_OK) != 0) return "cannot be read: " + ReasonOf(errno, path);
  return "";
}

std::ifstream OpenInput(const std::string& path) {
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) throw std::runtime_error(path + ": " + why);
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path + ": cannot be read: " + ReasonOf(errno, path));
  return file;
}

}  // namespace plslam
