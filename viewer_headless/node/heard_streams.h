// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <set>

#include "plslam/stream_t.hpp"

namespace plslam::viewer {

/// The streams that have begun or were resumed on a bus, and what the newest of them has announced.
class HeardStreams {
 public:
  /// Adds the begin of a stream, or its continuation by another player. Returns false if it was heard before: the
  /// history keeper may republish STREAM messages of a player that has exited, even after another one has resumed.
  bool Add(const stream_t& message);

  bool empty() const { return heard_.empty(); }
  /// Whether every frame of the newest stream is awaited.
  bool lockstep() const { return lockstep_; }
  /// -1: unknown.
  int64_t announced_frames() const { return announced_frames_; }

 private:
  std::set<int64_t> heard_;  // by session
  bool lockstep_ = false;
  int64_t announced_frames_ = -1;
};

}  // namespace plslam::viewer
