// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <type_traits>

#include <gtest/gtest.h>

namespace plslam::test {

inline double EnvironmentNumber(const char* name, double fallback) {
  const char* text = std::getenv(name);
  return text == nullptr ? fallback : std::atof(text);
}

/// Numbers of cases, and of accepted ones.
struct FuzzCounts {
  uint64_t cases = 0;
  uint64_t accepted = 0;
};

/// Calls `one_case` with fresh generators until the time is over (PLSLAM_FUZZ_SECONDS, default 2) or a test fails. Each
/// case depends on its seed only, which a failure prints; PLSLAM_FUZZ_SEED is the first one (default 1). It returns
/// whether its input was accepted, or nothing.
template <class Case>
FuzzCounts Fuzz(const Case& one_case) {
  using Clock = std::chrono::steady_clock;
  using Random = std::mt19937_64;
  constexpr bool kTells = std::is_same_v<std::invoke_result_t<Case, Random&>, bool>;
  const auto end = Clock::now() + std::chrono::duration<double>(EnvironmentNumber("PLSLAM_FUZZ_SECONDS", 2.0));
  auto seed = static_cast<uint64_t>(EnvironmentNumber("PLSLAM_FUZZ_SEED", 1.0));
  FuzzCounts counts;
  for (; Clock::now() < end && !testing::Test::HasFailure(); ++seed, ++counts.cases) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Random random(seed);
    if constexpr (kTells) {
      if (one_case(random)) ++counts.accepted;
    } else {
      one_case(random);
    }
  }
  std::printf("  %lu cases", static_cast<unsigned long>(counts.cases));
  if constexpr (kTells) std::printf(", %lu accepted", static_cast<unsigned long>(counts.accepted));
  std::printf("\n");
  return counts;
}

}  // namespace plslam::test
