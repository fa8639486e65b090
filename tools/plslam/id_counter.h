// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>
#include <cstdint>
#include <map>
#include <utility>

namespace plslam {

/// Counts different numbers of sessions. They ascend nearly without gaps, so each costs little more than a bit: a set
/// of landmarks was the greatest part of the memory of a long run's launcher.
class IdCounter {
 public:
  /// Negative ones do not count.
  void Add(int64_t session, int64_t id);
  int64_t count() const { return count_; }
  /// Memory of what has been counted, in bytes; never more than 40 MB: strangers may invent numbers.
  int64_t bytes() const;

 private:
  static constexpr int64_t kBlock = 4096;
  static constexpr size_t kMaxBlocks = 65536;

  std::map<std::pair<int64_t, int64_t>, std::bitset<kBlock>> blocks_;  // by session and id / kBlock
  int64_t count_ = 0;
};

}  // namespace plslam
