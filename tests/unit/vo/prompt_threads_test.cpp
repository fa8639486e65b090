#include "vo_process/prompt_threads.h"

#include <atomic>

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <gtest/gtest.h>

namespace plslam {
namespace {

TEST(PromptThreads, ShortTurnsLeavePolicyAndPriorityAsTheyWere) {
  std::thread thread([] {
    // Whoever starts the tracker with another priority has a reason.
    constexpr int kNice = 5;
    const auto self = static_cast<id_t>(gettid());
    ASSERT_EQ(setpriority(PRIO_PROCESS, self, kNice), 0);
    AskForShortTurns();
    EXPECT_EQ(getpriority(PRIO_PROCESS, self), kNice);
    EXPECT_EQ(sched_getscheduler(0), SCHED_OTHER);
  });
  thread.join();
}

TEST(PromptThreads, TheOtherThreadMayRunWhereTheCallerIsNot) {
  cpu_set_t own;
  CPU_ZERO(&own);
  ASSERT_EQ(sched_getaffinity(0, sizeof own, &own), 0);
  std::atomic<bool> done = false;
  std::thread other([&] { done.wait(false); });
  const int core = KeepOffThisCore(other);
  cpu_set_t cores;
  CPU_ZERO(&cores);
  EXPECT_EQ(pthread_getaffinity_np(other.native_handle(), sizeof cores, &cores), 0);
  done = true;
  done.notify_one();
  other.join();
  if (CPU_COUNT(&own) < 2) GTEST_SKIP() << "one core";
  ASSERT_GE(core, 0);
  EXPECT_FALSE(CPU_ISSET(static_cast<size_t>(core), &cores));
  EXPECT_EQ(CPU_COUNT(&cores), CPU_COUNT(&own) - 1);
}

}  // namespace
}  // namespace plslam
