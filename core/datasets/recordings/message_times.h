// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/recordings/recording.h"
#include "core/files/notes.h"

namespace plslam {

// Messages of a recording in order of their header stamps, as ROS compares them. The time of logging depends on the
// network, on the disk and on the recorder's clock: two images of one moment are logged up to a second apart.

/// Reads the stamps of the messages of several topics. The stamp of an unreadable message remains `kNotRead`.
///
/// All stamps are read if that takes a fraction of a second: of 8,000 messages, or of chunks that hold 512 MB of lz4.
/// In larger recordings each topic is divided into 16 stretches. If both ends of a stretch were logged after their
/// stamps by the same delay, within `tolerance_ns`, and its messages are equally spaced within that, the stamps in
/// between are interpolated (`is_estimated`); other stretches are halved. So every stamp is read in parts where
/// messages were logged late or at another rate.
void ReadStamps(const Recording& recording, const std::vector<std::vector<RecordedMessage>*>& topics,
                int64_t tolerance_ns);

/// Returns the stamp in the file; nullopt if it is zero or cannot be read.
std::optional<int64_t> ReadStamp(const Recording& recording, const RecordedMessage& message);

/// Returns the median step of the logging times.
int64_t MedianLogStep_ns(const std::vector<RecordedMessage>& messages);

/// Returns the reason why the stamps of these messages are no times ("are all zero"); empty if they are, or without
/// messages.
std::string StampComplaint(const std::vector<RecordedMessage>& messages);

/// Returns the median of stamp minus time of logging, of messages with both; 0 if there are none.
int64_t MedianStampOffset_ns(const std::vector<RecordedMessage>& messages);

/// Sets missing stamps to the time of logging plus `offset_ns`.
void StampByLogTime(int64_t offset_ns, std::vector<RecordedMessage>* messages);

enum class MessageClock { kStamp, kLog };

/// A part of a file.
struct FileRange {
  FilePlace begin{0, 0};
  FilePlace end{std::numeric_limits<uint32_t>::max(), std::numeric_limits<uint64_t>::max()};  ///< not in it
  bool Contains(const RecordedMessage& message) const { return begin <= PlaceOf(message) && PlaceOf(message) < end; }
};

/// The messages of a topic between two moments at which a clock was set back.
struct ClockPart {
  FileRange range;
  size_t n_messages = 0;
  int64_t first_ns = 0, last_ns = 0;
};
struct ClockParts {
  std::vector<ClockPart> parts;  ///< empty if no clock was set back
  std::string reason;            ///< "header stamps of /left go back by ..."
  bool all_repeat = true;        ///< each time it was set back to a time within the part before
};

/// Returns the parts of a topic in the order of the file.
ClockParts PartsByClock(const std::vector<RecordedMessage>& messages, MessageClock clock, const std::string& topic);

/// Returns the messages in order of the times of that clock, which become their `t_ns` and increase. `messages` are in
/// the order of the file.
///
/// By stamps, an unreadable message has the time of logging plus `MedianStampOffset_ns`; one with a stamp of zero is
/// skipped. Also skipped are messages with an equal time, up to three in a row of quite another time and, if a clock
/// was set back into the part before, those not later than an earlier one. `notes` reports this, and a clock that was
/// set forward, naming the `topic`.
std::vector<RecordedMessage> InOrderOfTime(std::vector<RecordedMessage> messages, MessageClock clock,
                                           const std::string& topic, Notes* notes);

}  // namespace plslam
