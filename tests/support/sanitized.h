// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <string>

namespace plslam::test {

/// Returns how long a test waits for an event; `limit` is for a build without sanitizers. Sanitized programs are five
/// to fifteen times slower. Promised times must not be tested with this limit.
inline std::chrono::milliseconds Patience(std::chrono::milliseconds limit) {
#ifdef PLSLAM_SANITIZED
  constexpr int kSlower = 10;
#else
  constexpr int kSlower = 1;
#endif
  return kSlower * limit;
}

/// Returns the first lines of sanitizer reports in the logs of processes; empty if there are none.
inline std::string SanitizerReports(const std::string& logs) {
  std::istringstream lines(logs);
  std::string reports;
  int left = 0;
  for (std::string line; std::getline(lines, line);) {
    const auto has = [&line](const char* text) { return line.find(text) != std::string::npos; };
    const bool begins = has("ERROR: AddressSanitizer") || has("ERROR: LeakSanitizer") || has(": runtime error: ") ||
                        has("WARNING: ThreadSanitizer") || has("FATAL: ThreadSanitizer");
    constexpr int kLines = 30;
    if (begins) left = kLines;
    if (left-- > 0) reports += line + "\n";
    left = left < 0 ? 0 : left;
  }
  return reports;
}

/// Fails the test if a sanitizer has reported an error in a process. Such a process exits, but a run restarts it, or is
/// over already: exit codes alone would not show it.
inline void ExpectNoSanitizerReports(const std::string& logs) { EXPECT_EQ(SanitizerReports(logs), ""); }

}  // namespace plslam::test
