// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/sanitized.h"

namespace plslam::test {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(SanitizerReports, HealthyProcessesHaveNone) {
  EXPECT_EQ(SanitizerReports(""), "");
  EXPECT_EQ(SanitizerReports("[vo] warning: no map for 15 s\nplayer: error: an image is missing\n"), "");
}

TEST(SanitizerReports, BeginWithTheErrorAndEndAfterThirtyLines) {
  std::string log = "[vo] ready\n==7==ERROR: AddressSanitizer: heap-use-after-free on address 0x1\n";
  for (int i = 0; i < 50; ++i) log += "    #" + std::to_string(i) + "\n";
  const std::string reports = SanitizerReports(log);
  EXPECT_THAT(reports, testing::StartsWith("==7==ERROR: AddressSanitizer"));
  EXPECT_THAT(reports, HasSubstr("    #28\n"));
  EXPECT_THAT(reports, Not(HasSubstr("    #29\n")));
}

TEST(SanitizerReports, AllSanitizersAreRecognised) {
  for (const char* line :
       {"==1==ERROR: LeakSanitizer: detected memory leaks", "a.cpp:3:4: runtime error: signed integer overflow",
        "WARNING: ThreadSanitizer: data race (pid=1)", "FATAL: ThreadSanitizer: unexpected memory mapping"}) {
    EXPECT_EQ(SanitizerReports("before\n" + std::string(line) + "\n"), std::string(line) + "\n");
  }
}

}  // namespace
}  // namespace plslam::test
