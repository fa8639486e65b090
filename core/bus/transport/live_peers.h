// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "core/ids/ids.h"

namespace plslam::bus {

/// Distinguishes message numbers that have been received before from new ones. The newest 64 may arrive out of order;
/// older ones count as received.
class ReplayWindow {
 public:
  /// Returns true the first time. Precondition: seq >= 0.
  bool Take(int64_t seq);

 private:
  int64_t newest_ = -1;
  uint64_t taken_ = 0;  // bit i: newest_ - i
};

/// The other processes that are known to be running. A MAC proves the author of a message, but not its time: a
/// recording of an exited process stays genuine. Each process draws its name (`source`) at random when it starts, so a
/// genuine message that names ours was written after our start; its author is running, and from then on the numbers of
/// its messages distinguish new from old. Time in nanoseconds of any steady clock; not thread-safe.
class LivePeers {
 public:
  static constexpr size_t kMaxPeers = 256;

  /// A genuine message of `source` named us.
  void Prove(SourceId source, int64_t now);
  bool IsAlive(SourceId source) const;

  /// A genuine message of a source that has not named this process yet.
  struct Doubt {
    bool ask = false;         ///< request now a message that names us (at most 100 such requests in a second, in all)
    bool is_overdue = false;  ///< it has had ample time to answer
  };
  Doubt OnSignOfLife(SourceId source, int64_t now);

  /// Returns whether this request or announcement of `source` is a new one.
  bool TakeRequest(SourceId source, int64_t seq, int64_t now) { return PeerOf(source, now).requests.Take(seq); }
  bool TakeAnnouncement(SourceId source, int64_t seq, int64_t now) {
    return PeerOf(source, now).announcements.Take(seq);
  }

 private:
  struct Peer {
    bool lives = false;
    int64_t first = 0;  // heard
    int64_t heard = 0;
    int64_t ask_at = 0;
    int64_t ask_pause = 0;
    ReplayWindow requests;
    ReplayWindow announcements;
  };
  Peer& PeerOf(SourceId source, int64_t now);

  std::map<SourceId, Peer> peers_;
  int64_t second_began_ = 0;  // in which `asked_` requests were sent
  int asked_ = 0;
};

}  // namespace plslam::bus
