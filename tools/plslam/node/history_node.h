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
#include "core/ids/ids.h"

namespace plslam {
class camera_t;
}  // namespace plslam

namespace plslam::launcher {

/// Keeps the messages of the other processes on the channels whose publishers retain everything (poses, keyframes,
/// loops, true poses, begin and end of streams), and republishes those of a process that has exited: its history is
/// gone, and a process that starts later could not get them any more. Sessions, times and the order are preserved; the
/// publisher is then this process, so readers receive repeated messages, and ignore them by session and number. The
/// camera, which its publisher repeats every second, is repeated on its behalf.
///
/// The messages are stored in a file without a name, which is removed with this process. If the disk is full, no more
/// messages are kept, and `problem` gives the reason: the run continues.
class HistoryKeeper {
 public:
  /// Construct before `Bus::Run`. The file is created in `folder`.
  HistoryKeeper(bus::Bus& bus, const std::filesystem::path& folder);
  ~HistoryKeeper();
  HistoryKeeper(const HistoryKeeper&) = delete;
  HistoryKeeper& operator=(const HistoryKeeper&) = delete;

  /// Handles the exit of a process. Called on the thread of `Bus::Run`; the work is done on another.
  void OnExit(pid_t pid);
  /// All processes are about to exit: no reader is left, and nothing is republished from here on.
  void Stop();

  /// Numbers of kept and of republished messages.
  int64_t kept() const;
  int64_t said_again() const { return republished_; }
  /// Reason why no more messages are kept; empty if there is none.
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
  void RepublishRig();

  bus::Bus& bus_;
  std::map<int64_t, SourceId> sources_;  // by process id; on the thread of the bus
  std::unique_ptr<camera_t> camera_;     // newest of another; on the thread of the bus
  std::shared_ptr<Store> store_;
  std::atomic<int64_t> republished_{0};
  std::thread worker_;
};

}  // namespace plslam::launcher
