// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

namespace plslam::bus {

/// The number of received messages of each publisher. Compared with the count in the publisher's status it reveals
/// whether more messages are on their way.
///
/// A process that replaces a killed one publishes everything again. Repaired messages of the killed one can arrive later
/// than its first ones: the newest publisher is the one whose first message was the last to arrive.
class ReceivedMessages {
 public:
  /// Returns whether the message is from the newest publisher.
  bool Add(int64_t source) {
    // A publisher with a new number for each message must not fill the memory.
    if (counts_.size() >= kMostSources && !counts_.contains(source)) counts_.clear();
    if (++counts_[source] == 1) newest_ = source;
    return source == newest_;
  }
  int64_t From(int64_t source) const {
    const auto found = counts_.find(source);
    return found == counts_.end() ? 0 : found->second;
  }

 private:
  static constexpr size_t kMostSources = 64;
  std::map<int64_t, int64_t> counts_;
  int64_t newest_ = 0;
};

}  // namespace plslam::bus
