// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/side_worker.h"

#include <algorithm>
#include <latch>
#include <stdexcept>
#include <thread>

#include <sched.h>

#include <gtest/gtest.h>

namespace plslam::vo {
namespace {

int CoresOfThisThread() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  return sched_getaffinity(0, sizeof cores, &cores) == 0 ? CPU_COUNT(&cores) : 0;
}

TEST(SideWorker, RunsBothEachTime) {
  SideWorker worker;
  int here = 0;
  int there = 0;
  // With so little work, either thread may take a task first.
  for (int i = 0; i < 10'000; ++i) worker.RunBoth([&] { ++here; }, [&] { ++there; });
  EXPECT_EQ(here, 10'000);
  EXPECT_EQ(there, 10'000);
}

TEST(SideWorker, RunsOnAnotherThreadAndLeavesACoreToTheCaller) {
  SideWorker worker;
  std::latch begun(1);
  std::thread::id there;
  int cores_there = 0;
  const auto wait = [&] { begun.wait(); };
  worker.RunBoth(wait, [&] {
    there = std::this_thread::get_id();
    cores_there = CoresOfThisThread();
    begun.count_down();
  });
  EXPECT_NE(there, std::this_thread::get_id());
  EXPECT_EQ(cores_there, std::max(1, CoresOfThisThread() - 1));
}

TEST(SideWorker, RethrowsAndStaysUsable) {
  SideWorker worker;
  const auto fail = [] { throw std::runtime_error("no"); };
  const auto nothing = [] {};
  EXPECT_THROW(worker.RunBoth(fail, nothing), std::runtime_error);
  EXPECT_THROW(worker.RunBoth(nothing, fail), std::runtime_error);
  EXPECT_THROW(worker.RunBoth(fail, fail), std::runtime_error);
  int ran = 0;
  worker.RunBoth([&] { ++ran; }, nothing);
  EXPECT_EQ(ran, 1);
}

}  // namespace
}  // namespace plslam::vo
