// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process_signals.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <thread>

namespace plslam::bus {
namespace {

/// Stops at a signal, while a second one of the same moment is pending until the mask is restored.
void StopWhileAnotherIsPending() {
  std::atomic<bool> stopped = false;
  {
    const SignalWatcher watcher([&](const std::string&) {
      kill(getpid(), SIGINT);
      stopped = true;
      std::this_thread::sleep_for(std::chrono::milliseconds(100));  // meanwhile the destructor ends the watch
    });
    kill(getpid(), SIGINT);
    while (!stopped) std::this_thread::yield();
  }
  std::_Exit(0);
}

TEST(SignalWatcher, PendingSecondSignalEndsNothing) {
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(StopWhileAnotherIsPending(), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace plslam::bus
