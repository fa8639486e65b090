// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <exception>

#include "core/bus/bus.h"

namespace plslam::bus {

/// For threads that work beside that of `Bus::Run`: runs `work`; what goes wrong in it ends the process where the run
/// loop sees it.
template <class Work>
void RunGuarded(Bus& bus, const Work& work) {
  std::exception_ptr failure;
  try {
    work();
  } catch (...) {
    failure = std::current_exception();
  }
  // Only now, so that the exception is no longer this thread's too.
  if (failure) bus.Post([failure = std::move(failure)] { std::rethrow_exception(failure); });
}

/// Steady time, for durations.
inline double NowMs() {
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch()).count();
}
inline double NowS() { return 1e-3 * NowMs(); }

}  // namespace plslam::bus
