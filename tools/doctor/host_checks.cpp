// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/host_checks.h"

#include <unistd.h>

#include <sys/statvfs.h>
#include <sys/timex.h>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <exception>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <time.h>

#include "core/files/shared_file.h"
#include "core/places/vocabulary.h"

namespace plslam::doctor {
namespace {

/// NTP slews by up to 500 ppm; beyond 5 ms over a few seconds the clock was set.
constexpr double kLargestPace = 1000e-6;
constexpr double kStep_s = 0.005;

int64_t Read(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

}  // namespace

ClockSample SampleClocks() { return {Read(CLOCK_REALTIME), Read(CLOCK_MONOTONIC_RAW)}; }

bool ClockIsSynchronised() {
  timex state{};
  return adjtimex(&state) != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
}

Findings CheckClock(const ClockSample& begin, const ClockSample& end, bool synchronised) {
  Findings findings;
  const std::string keep = AsRoot("timedatectl set-ntp true");
  const double steady_s = 1e-9 * static_cast<double>(end.steady_ns - begin.steady_ns);
  const double apart_s = 1e-9 * static_cast<double>(end.wall_ns - begin.wall_ns) - steady_s;
  if (std::abs(apart_s) > kStep_s + kLargestPace * steady_s) {
    findings.push_back(Problem("clock",
                               fmt::format("the clock of this host was set by {:+.3f} s within {:.1f} s: something "
                                           "sets it instead of slewing it",
                                           apart_s, steady_s),
                               keep));
  }
  if (!synchronised) {
    findings.push_back(Advice(
        "clock",
        "the clock of this host is not synchronised: times of logs and live cameras of several hosts will not agree",
        keep));
  }
  if (findings.empty()) findings.push_back(Good("clock", "the clock is synchronised and runs at a constant rate"));
  return findings;
}

namespace {

namespace fs = std::filesystem;

constexpr double kTooLittle_MB = 200.0;
constexpr double kLittle_MB = 2000.0;
constexpr std::array kPrograms = {"player", "vo_process", "mapping_process", "loop_process", "viewer_headless"};

/// The folder itself, or the nearest one above it that is there.
fs::path NearestThatIs(const fs::path& folder) {
  std::error_code error;
  fs::path path = fs::absolute(folder, error);
  while (!fs::exists(path, error) && path.has_relative_path()) path = path.parent_path();
  return path;
}

}  // namespace

Findings CheckFolder(const fs::path& folder, const std::string& use, const std::string& mend) {
  const fs::path there = NearestThatIs(folder);
  const std::string name = there.string();
  std::error_code error;
  if (!fs::is_directory(there, error)) {
    return {Problem("disk", fmt::format("{} (for {}) is not a folder", name, use), mend)};
  }
  if (access(there.c_str(), W_OK | X_OK) != 0) {
    return {Problem("disk", fmt::format("{} cannot be written to {}: {}", use, name, std::strerror(errno)), mend)};
  }
  struct statvfs space {};
  if (statvfs(there.c_str(), &space) != 0) {
    return {Problem("disk", fmt::format("{} cannot be examined: {}", name, std::strerror(errno)), mend)};
  }
  const double free_MB = 1e-6 * static_cast<double>(space.f_bavail) * static_cast<double>(space.f_frsize);
  const std::string what = fmt::format("{:.0f} MB are free for {} in {}", free_MB, use, name);
  if (free_MB < kTooLittle_MB) return {Problem("disk", what, mend)};
  if (free_MB < kLittle_MB) return {Advice("disk", what + ": not much for a long run", mend)};
  return {Good("disk", what)};
}

Findings CheckVocabulary(const std::string& name, const std::string& kind, const std::string& key) {
  std::error_code error;
  const fs::path path = FindSharedFile(name);
  const std::string mend = fmt::format(
      "train_vocabulary --kind {0} --out {0}.vocabulary synthetic:room synthetic:street   # and --set "
      "{1}={0}.vocabulary",
      kind, key);
  if (!fs::exists(path, error)) {
    return {Problem("vocabulary",
                    fmt::format("{}: no vocabulary of {} is here or at {}: loop_process will not start", name, kind,
                                SharedFile(name).string()),
                    mend)};
  }
  try {
    const Vocabulary vocabulary = Vocabulary::Load(path.string());
    return {Good("vocabulary", fmt::format("{}: {} words of {}", path.string(), vocabulary.words(), kind))};
  } catch (const std::exception& damage) {
    return {Problem("vocabulary", damage.what(), mend)};
  }
}

Findings CheckPrograms() {
  std::vector<std::string> missing;
  for (const char* program : kPrograms) {
    if (access((ProgramFolder() / program).c_str(), X_OK) != 0) missing.emplace_back(program);
  }
  const std::string folder = ProgramFolder().string();
  if (missing.empty()) return {Good("programs", "all programs of a run are in " + folder)};
  return {Problem("programs", fmt::format("not in {}, or not executable: {}", folder, fmt::join(missing, ", ")),
                  "scripts/build release plslam_programs   # or install the package again")};
}

}  // namespace plslam::doctor
