// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/messages/map_pages.h"
#include "core/map/map.h"
#include "core/map/map_follower.h"
#include "core/map/map_update.h"
#include "plslam/map_update_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam::test {

/// Follows the map as it is published.
class PublishedMap {
 public:
  void Add(const map_update_t& page) {
    if (assembler_.Add(page) == bus::PageOutcome::kComplete) follower_.Apply(assembler_.Take());
  }
  const Map& map() const { return follower_.map(); }
  /// All of it, as if it were the first version.
  MapUpdate Whole() const;

 private:
  bus::MapUpdateAssembler assembler_;
  MapFollower follower_;
};

/// Content of the LCM log of a run.
struct RecordedRun {
  /// Messages by channel.
  std::map<std::string, int> counts;
  /// Sequence numbers by channel and publisher, in the order of the log.
  std::map<std::pair<std::string, int64_t>, std::vector<int64_t>> sequence_numbers;
  /// POSE and KEYFRAME messages without the parts that differ between runs of the same data: the publisher's random
  /// names, and in poses the stage times.
  std::vector<std::vector<uint8_t>> poses;
  std::vector<std::vector<uint8_t>> keyframes;
  /// The map at the end of the log, as a listener that follows MAP_UPDATE has it; `map_bytes` are its messages
  /// without the random names.
  MapTotals map_totals;
  std::vector<uint8_t> map_bytes;
  std::vector<stream_t> streams;
  std::vector<status_t> statuses;
  int undecodable = 0;

  int Count(const std::string& channel) const;
  /// Missing or doubled numbers of a channel, over all publishers; each must begin with 0.
  int Gaps(const std::string& channel) const;
};

/// Throws std::runtime_error if there is no such log.
RecordedRun ReadRecordedRun(const std::string& log);

}  // namespace plslam::test
