// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/datasets/recordings/message_times.h"
#include "core/datasets/recordings/recording.h"
#include "core/files/notes.h"

namespace plslam {

/// Left and right images of a recording, pair by pair in order of time.
struct ImagePairs {
  std::vector<std::pair<RecordedMessage, RecordedMessage>> pairs;
  MessageClock clock = MessageClock::kStamp;  ///< of the times
  int64_t stamp_offset_ns = 0;                ///< the median stamp minus time of logging of left images
  int64_t step_ns = 0;                        ///< the median distance of left images
  FileRange range;                            ///< of the part of the file that is played
};

/// Delays of logging that differ by this part of a frame leave no doubt about the pairs.
inline constexpr int64_t kDelayToleranceShare = 8;

/// Pairs the nearest images of two topics that are less than half a frame apart, by their header stamps. Logging times
/// are used if the stamps of a topic are zero or constant, or those of both are of different clocks; `notes` reports
/// this, and skipped messages. Where the clock was set back, the file has parts, of which `part` is played, from 1; 0:
/// all of them, which is an error unless their times overlap. Throws DatasetError if there is no pair.
ImagePairs PairImages(const Recording& recording, const std::string& left_topic, const std::string& right_topic,
                      size_t part, Notes* notes);

/// The time of a pair. A stamp that was estimated is read now, and stays between the neighbours, so that times
/// increase.
int64_t TimeOf(const Recording& recording, const ImagePairs& images, size_t index);

}  // namespace plslam
