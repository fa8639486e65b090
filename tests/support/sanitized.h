// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <sstream>
#include <string>

namespace plslam::test {

/// How long a test waits for what must come in the end; `limit` is meant for a build as users have it. Sanitized
/// programs are five to fifteen times slower. Nothing that is promised in seconds may be judged by this.
inline std::chrono::milliseconds Patience(std::chrono::milliseconds limit) {
#ifdef PLSLAM_SANITIZED
  constexpr int kSlower = 10;
#else
  constexpr int kSlower = 1;
#endif
  return kSlower * limit;
}

/// The first lines of what sanitizers have found, out of the logs of processes; empty where they found nothing.
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

/// Fails the test where a sanitizer has found something in a process. Such a process ends, but a run starts it again,
/// or is over already: by exit codes alone it would go unnoticed.
inline void ExpectNoSanitizerReports(const std::string& logs) { EXPECT_EQ(SanitizerReports(logs), ""); }

}  // namespace plslam::test
