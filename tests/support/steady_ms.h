// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>

namespace plslam::test {

/// For differences.
inline double SteadyMs() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace plslam::test
