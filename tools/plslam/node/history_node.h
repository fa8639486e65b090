// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <thread>

#include "core/bus/bus.h"

namespace plslam {
class camera_t;
}  // namespace plslam

namespace plslam::launcher {

/// Keeps what the other processes have said on the channels whose publishers keep everything (poses, keyframes,
/// loops, true poses, begin and end of streams), and says it in their place when one of them has died: its history
/// has gone with it, and a process that starts later could not have it any more. Sessions, times and the order stay;
/// the publisher is then this one, so whoever has heard it before hears it twice, and passes it over by session and
/// number. The camera, which its publisher repeats every second, is repeated in its place.
///
/// Lies in a file without a name, which goes with this process. Where the disk takes no more, nothing is kept from
/// there on, and `problem` says why: the run goes on.
class HistoryKeeper {
 public:
  /// Before `Bus::Run`. The file is made in `folder`.
  HistoryKeeper(bus::Bus& bus, const std::filesystem::path& folder);
  ~HistoryKeeper();
  HistoryKeeper(const HistoryKeeper&) = delete;
  HistoryKeeper& operator=(const HistoryKeeper&) = delete;

  /// The process has ended. On the thread of `Bus::Run`; the work is done on another.
  void OnExit(pid_t pid);
  /// All processes end: nobody is left who could lack what one of them said, and nothing is said again from here on.
  void Stop();

  /// Messages kept, and said again for others.
  int64_t kept() const;
  int64_t said_again() const { return republished_; }
  /// Why nothing is kept any more; empty where all is well.
  std::string problem() const;

 private:
  struct Entry {
    size_t channel = 0;  ///< row of the table of channels
    int64_t offset = 0;
    size_t bytes = 0;
  };
  /// Outlives this object where the receiving thread of the bus still holds it.
  struct Store;

  void Work();
  bool Republish(const Entry& entry);
  void SayCamera();

  bus::Bus& bus_;
  std::map<int64_t, int64_t> sources_;  // by process id; on the thread of the bus
  std::unique_ptr<camera_t> camera_;    // newest of another; on the thread of the bus
  std::shared_ptr<Store> store_;
  std::atomic<int64_t> republished_{0};
  std::thread worker_;
};

}  // namespace plslam::launcher
