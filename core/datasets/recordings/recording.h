// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plslam {

/// A topic of a recording, as one publisher wrote it.
struct RecordedChannel {
  uint32_t id = 0;
  std::string topic;
  std::string type;      ///< of its messages, as ROS 2 names it: "sensor_msgs/msg/Image"
  std::string encoding;  ///< of its messages: "cdr" (ROS 2), "ros1"
};

/// The name that ROS 2 has for a type: "sensor_msgs/Image" of ROS 1 is "sensor_msgs/msg/Image".
inline std::string RosTypeName(std::string type) {
  const size_t slash = type.find('/');
  if (slash != std::string::npos && type.find('/', slash + 1) == std::string::npos) type.insert(slash, "/msg");
  return type;
}

/// Where a message stands.
struct RecordedMessage {
  static constexpr uint32_t kNoChunk = std::numeric_limits<uint32_t>::max();
  static constexpr int64_t kNotRead = -1;

  int64_t t_ns = 0;             ///< when it was logged
  int64_t stamp_ns = kNotRead;  ///< of its header; 0: none
  uint32_t chunk = 0;           ///< index of its chunk, in the order in which they stand in the file
  uint64_t offset = 0;          ///< in the chunk, decompressed; in the file where it is in no chunk
  bool is_estimated = false;    ///< its stamp follows from those of others (message_times.h)
};

/// A stamp lies within so many bytes of a message: in ROS 1 behind its number, in ROS 2 behind the name of the encoding.
inline constexpr uint64_t kStampBytes = 12;

/// The stamp of the std_msgs/Header that a message begins with; `kNotRead` where it ends before.
inline int64_t StampOf(std::span<const uint8_t> begin) {
  if (begin.size() < kStampBytes) return RecordedMessage::kNotRead;
  std::array<uint32_t, 2> stamp{};  // seconds, nanoseconds
  std::memcpy(stamp.data(), begin.data() + sizeof(uint32_t), sizeof(stamp));
  return int64_t{stamp[0]} * 1'000'000'000 + stamp[1];
}

/// The order in which messages stand in the file: a recorder writes them as they arrive, whatever its clock says.
inline void SortByPlace(std::vector<RecordedMessage>& messages) {
  std::stable_sort(messages.begin(), messages.end(), [](const RecordedMessage& a, const RecordedMessage& b) {
    return std::pair(a.chunk, a.offset) < std::pair(b.chunk, b.offset);
  });
}

/// A file of messages with an index: opening reads what the end of the file says, `Messages` the index of one topic,
/// and `Read` the chunk of a message. The chunks read last are kept; memory grows by 40 bytes for each message. A file
/// without a usable index (its recorder was killed, or does not write one) is read once from its begin to its end
/// when it is opened, as far as it is whole (scanned_index.h); `Notes` tells.
///
/// All throw DatasetError, without the name of the file: where it is another file, or is damaged. May be used by
/// several threads.
class Recording {
 public:
  /// What `Messages` throws where the index is damaged behind what was read when the file was opened. It is opened
  /// again, with this as the reason to read all of it in place of its index.
  class DamagedIndex : public std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  Recording() = default;
  virtual ~Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// In order of their ids.
  virtual const std::vector<RecordedChannel>& channels() const = 0;

  /// All messages of the channels with this topic, in the order in which they stand in the file.
  virtual std::vector<RecordedMessage> Messages(const std::string& topic) const = 0;

  /// What is wrong with the file, in sentences for the user.
  virtual std::vector<std::string> Notes() const = 0;
  /// How long it took to read all of the file in place of its index; 0: its index is used.
  virtual double scan_s() const = 0;

  /// The content of a message, a copy.
  virtual std::vector<uint8_t> Read(const RecordedMessage& message) const = 0;

  /// The first `n` bytes of it, or all where it has fewer. Where its chunk is not compressed, only these are read.
  virtual std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const = 0;
  /// Tells the system that `ReadBegin` will come, where its chunk is not compressed.
  virtual void WillReadBegin(const RecordedMessage& message, uint64_t n) const = 0;
  /// How many bytes of lz4 could be decompressed in the time that this chunk takes; 0: it is not compressed.
  virtual uint64_t DecompressionCost(uint32_t chunk) const = 0;
};

}  // namespace plslam
