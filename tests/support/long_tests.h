// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>

namespace plslam::test {

/// Returns whether slow tests are to be run, too: scripts/soak sets PLSLAM_LONG_TESTS.
inline bool LongTests() { return std::getenv("PLSLAM_LONG_TESTS") != nullptr; }

}  // namespace plslam::test

/// Leaves the test, visibly skipped, where only short ones are to run.
#define PLSLAM_REQUIRE_LONG_TESTS() \
  if (!plslam::test::LongTests()) GTEST_SKIP() << "long: runs with PLSLAM_LONG_TESTS=1 (scripts/soak)"
