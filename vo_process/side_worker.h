#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace plslam {

/// One thread that works beside the caller's: the right image while the caller does the left.
class SideWorker {
 public:
  SideWorker();
  ~SideWorker();
  SideWorker(const SideWorker&) = delete;
  SideWorker& operator=(const SideWorker&) = delete;

  /// Runs `here` on the calling thread and `there` on the worker's, and returns when both are done. Throws what they
  /// throw, `here`'s first.
  void RunBoth(const std::function<void()>& here, const std::function<void()>& there);

 private:
  void Loop();

  std::mutex mutex_;
  std::condition_variable changed_;
  const std::function<void()>* job_ = nullptr;
  std::exception_ptr error_;
  bool stopping_ = false;
  std::thread thread_;
};

}  // namespace plslam
