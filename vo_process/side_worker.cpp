#include "vo_process/side_worker.h"

#include <exception>
#include <utility>

namespace plslam {

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
  {
    const std::lock_guard lock(mutex_);
    job_ = &there;
  }
  changed_.notify_all();
  std::exception_ptr error;
  try {
    here();
  } catch (...) {
    error = std::current_exception();
  }
  // `there` refers to the caller's data, so it is awaited whatever happened here.
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return job_ == nullptr; });
  const std::exception_ptr error_there = std::exchange(error_, nullptr);
  lock.unlock();
  if (error) std::rethrow_exception(error);
  if (error_there) std::rethrow_exception(error_there);
}

void SideWorker::Loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return stopping_ || job_ != nullptr; });
    if (job_ == nullptr) return;
    const std::function<void()>& job = *job_;
    lock.unlock();
    std::exception_ptr error;
    try {
      job();
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    error_ = error;
    job_ = nullptr;
    changed_.notify_all();
  }
}

}  // namespace plslam
