// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor/clock_check.h"

#include <cmath>

#include <fmt/format.h>
#include <sys/timex.h>
#include <time.h>

namespace plslam {
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
    findings.push_back(Advice("clock",
                              "nothing keeps the clock of this host right: times of logs and of live cameras of "
                              "several hosts will not agree",
                              keep));
  }
  if (findings.empty()) findings.push_back(Good("clock", "the clock is kept right, and runs at one pace"));
  return findings;
}

}  // namespace plslam
