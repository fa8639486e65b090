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

#include "core/files/notes.h"

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

/// Position of a message in a recording.
struct RecordedMessage {
  static constexpr uint32_t kNoChunk = std::numeric_limits<uint32_t>::max();
  static constexpr int64_t kNotRead = -1;

  int64_t t_ns = 0;             ///< when it was logged
  int64_t stamp_ns = kNotRead;  ///< of its header; 0: none
  uint32_t chunk = 0;           ///< index of its chunk, in the order of the file
  uint64_t offset = 0;          ///< in the decompressed chunk; in the file if it is in no chunk
  bool is_estimated = false;    ///< its stamp was interpolated between others (message_times.h)
};

/// Returns the time of logging that a field holds, at most the year 2116: a damaged one may hold any number, and the
/// difference between a stamp and a time, added to another time, must not overflow.
inline int64_t LogTime(uint64_t field_ns) {
  constexpr uint64_t kLatest_ns = uint64_t{1} << 62;
  return static_cast<int64_t>(std::min(field_ns, kLatest_ns));
}

/// A stamp lies within this many bytes from the beginning of a message: in ROS 1 after its number, in ROS 2 after the
/// name of the encoding.
inline constexpr uint64_t kStampBytes = 12;

/// Returns the stamp of the std_msgs/Header at the beginning of a message; `kNotRead` if the bytes end before.
inline int64_t StampOf(std::span<const uint8_t> begin) {
  if (begin.size() < kStampBytes) return RecordedMessage::kNotRead;
  std::array<uint32_t, 2> stamp{};  // seconds, nanoseconds
  std::memcpy(stamp.data(), begin.data() + sizeof(uint32_t), sizeof(stamp));
  return int64_t{stamp[0]} * 1'000'000'000 + stamp[1];
}

/// Position of a message in the order of the file: its chunk, and its offset there.
using FilePlace = std::pair<uint32_t, uint64_t>;
inline FilePlace PlaceOf(const RecordedMessage& message) { return {message.chunk, message.offset}; }

/// Sorts messages in the order of the file: a recorder writes them in the order of arrival, whatever its clock shows.
inline void SortByPlace(std::vector<RecordedMessage>& messages) {
  std::stable_sort(messages.begin(), messages.end(),
                   [](const RecordedMessage& a, const RecordedMessage& b) { return PlaceOf(a) < PlaceOf(b); });
}

/// A file of messages with an index: opening reads the summary at the end of the file, `Messages` the index of one
/// topic, and `Read` the chunk of a message. The most recently read chunks are kept; memory grows by 40 bytes for each
/// message. A file without a usable index (its recorder was killed, or does not write one) is read once from beginning
/// to end when it is opened, as far as it is complete (scanned_index.h); `Notes` reports this.
///
/// All throw DatasetError, without the name of the file, if it has another format or is damaged. May be used by several
/// threads.
class Recording {
 public:
  /// Thrown by `Messages` if the index is damaged beyond the part that was read when the file was opened. The caller
  /// opens the file again, with this as the reason to read the whole file instead of its index.
  class DamagedIndex : public std::runtime_error {
    using std::runtime_error::runtime_error;
  };

  Recording() = default;
  virtual ~Recording() = default;
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  /// In order of their ids.
  virtual const std::vector<RecordedChannel>& channels() const = 0;

  /// Returns all messages of the channels with this topic, in the order of the file.
  virtual std::vector<RecordedMessage> Messages(const std::string& topic) const = 0;

  /// Returns what is known of defects of the file.
  virtual plslam::Notes Notes() const = 0;
  /// Returns the time that it took to read the whole file instead of its index; 0: its index is used.
  virtual double scan_s() const = 0;

  /// Returns a copy of the content of a message.
  virtual std::vector<uint8_t> Read(const RecordedMessage& message) const = 0;

  /// Returns its first `n` bytes, or all if it has fewer. In an uncompressed chunk, only these are read.
  virtual std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const = 0;
  /// Announces a call of `ReadBegin` to the operating system if the chunk is not compressed.
  virtual void WillReadBegin(const RecordedMessage& message, uint64_t n) const = 0;
  /// Returns the bytes of lz4 that could be decompressed in the time that this chunk takes; 0: it is not compressed.
  virtual uint64_t DecompressionCost(uint32_t chunk) const = 0;
};

}  // namespace plslam
