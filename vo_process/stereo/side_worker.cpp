// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/stereo/side_worker.h"

#include <pthread.h>
#include <sched.h>

#include <exception>
#include <utility>

namespace plslam::vo {
namespace {

std::exception_ptr ErrorOf(const std::function<void()>& job) {
  try {
    job();
  } catch (...) {
    return std::current_exception();
  }
  return nullptr;
}

}  // namespace

SideWorker::SideWorker() : thread_([this] { Loop(); }) {}

SideWorker::~SideWorker() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void SideWorker::RunBoth(const std::function<void()>& here, const std::function<void()>& there) {
  AvoidCurrentCore();
  {
    const std::lock_guard lock(mutex_);
    job_ = &there;
  }
  changed_.notify_all();
  const std::exception_ptr error = ErrorOf(here);
  std::unique_lock lock(mutex_);
  std::exception_ptr error_there;
  if (std::exchange(job_, nullptr) != nullptr) {
    lock.unlock();
    error_there = ErrorOf(there);
  } else {
    // `there` refers to the caller's data, so wait for it even after an exception here.
    changed_.wait(lock, [this] { return !working_; });
    error_there = std::exchange(error_, nullptr);
    lock.unlock();
  }
  if (error) std::rethrow_exception(error);
  if (error_there) std::rethrow_exception(error_there);
}

/// The caller seldom changes its core, so this usually only reads the core's number. If no core can be avoided (there
/// is only one, or the caller is bound to one), or the system refuses, the scheduler decides.
void SideWorker::AvoidCurrentCore() {
  const int core = sched_getcpu();
  if (core < 0 || core >= CPU_SETSIZE || core == std::exchange(avoided_core_, core)) return;
  cpu_set_t cores;
  CPU_ZERO(&cores);
  if (sched_getaffinity(0, sizeof cores, &cores) != 0) return;
  CPU_CLR(static_cast<size_t>(core), &cores);
  if (CPU_COUNT(&cores) > 0) pthread_setaffinity_np(thread_.native_handle(), sizeof cores, &cores);
}

void SideWorker::Loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || job_ != nullptr; });
    if (job_ == nullptr) return;
    const std::function<void()>& job = *std::exchange(job_, nullptr);
    working_ = true;
    lock.unlock();
    std::exception_ptr error = ErrorOf(job);
    lock.lock();
    error_ = std::move(error);
    working_ = false;
    changed_.notify_all();
  }
}

}  // namespace plslam::vo
