#include "vo_process/prompt_threads.h"

#include <cstdint>

#include <pthread.h>
#include <sched.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace plslam {
namespace {

constexpr uint64_t kShortestTurn_ns = 100'000;  // what the kernel allows

/// `struct sched_attr` of the kernel, first version; the headers of Debian 12 do not have it beside <sched.h>.
struct SchedulingAttributes {
  uint32_t size = sizeof(SchedulingAttributes);
  uint32_t policy = SCHED_OTHER;
  uint64_t flags = 0;
  int32_t nice = 0;
  uint32_t priority = 0;
  uint64_t runtime_ns = 0;
  uint64_t deadline_ns = 0;
  uint64_t period_ns = 0;
};

}  // namespace

void AskForShortTurns() {
  SchedulingAttributes now;
  if (syscall(SYS_sched_getattr, 0, &now, sizeof now, 0) != 0 || now.policy != SCHED_OTHER) return;
  SchedulingAttributes wanted;
  wanted.nice = now.nice;
  wanted.runtime_ns = kShortestTurn_ns;
  syscall(SYS_sched_setattr, 0, &wanted, 0);
}

int KeepOffThisCore(std::thread& thread) {
  const int core = sched_getcpu();
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (core < 0 || core >= CPU_SETSIZE || sched_getaffinity(0, sizeof cores, &cores) != 0) return core;
  CPU_CLR(static_cast<size_t>(core), &cores);
  if (CPU_COUNT(&cores) > 0) pthread_setaffinity_np(thread.native_handle(), sizeof cores, &cores);
  return core;
}

}  // namespace plslam
