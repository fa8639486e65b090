// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/recordings/recording.h"

namespace plslam {

// Messages of a recording in order of their header stamps, as ROS compares them. When a message was logged depends on
// the network, on the disk and on the clock of the recorder: two images of one moment are logged up to a second apart.

/// Reads the stamps of the messages of several topics. A message whose stamp cannot be read keeps `kNotRead`.
///
/// All are read where that takes a fraction of a second: of 8,000 messages, or of chunks that hold 512 MB of lz4. In
/// larger recordings 16 stretches of each topic are taken. Where its ends were logged after their stamps by one delay,
/// within `tolerance_ns`, and its messages at equal distances within that, the stamps between follow (`is_estimated`);
/// other stretches are halved. So every stamp is read where messages were logged late or at another rate.
void ReadStamps(const Recording& recording, const std::vector<std::vector<RecordedMessage>*>& topics,
                int64_t tolerance_ns);

/// The stamp as the file has it; nullopt where it is zero or cannot be read.
std::optional<int64_t> ReadStamp(const Recording& recording, const RecordedMessage& message);

/// The median distance of the times of logging.
int64_t MedianLogStep_ns(const std::vector<RecordedMessage>& messages);

/// Why the stamps of these messages are no times ("are all zero"); empty where they are, or where there is no message.
std::string StampComplaint(const std::vector<RecordedMessage>& messages);

/// The median of stamp minus time of logging, of messages with both; 0 where there are none.
int64_t MedianStampOffset_ns(const std::vector<RecordedMessage>& messages);

/// Gives messages without a stamp the time at which they were logged plus `offset_ns`.
void StampByLogTime(int64_t offset_ns, std::vector<RecordedMessage>* messages);

enum class MessageClock { kStamp, kLog };

/// The messages in order of the times of that clock, which are their `t_ns` then and increase. `messages` are in the
/// order in which they stand in the file.
///
/// By stamps, a message that could not be read has the time at which it was logged plus `MedianStampOffset_ns`; one
/// with a stamp of zero is passed over. So are those of a time that another one has, and where a clock was set back,
/// those not later than one before. `notes` says so, naming the `topic`.
std::vector<RecordedMessage> InOrderOfTime(std::vector<RecordedMessage> messages, MessageClock clock,
                                           const std::string& topic, std::vector<std::string>* notes);

}  // namespace plslam
