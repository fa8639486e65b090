// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "core/bus/channels.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/messages/convert.h"
#include "core/bus/transport/wire.h"
#include "core/ids/ids.h"

namespace plslam::bus {

/// Position of a message in a log.
struct LogPlace {
  int64_t offset = 0;
  int64_t bytes = 0;
};

/// Returns nullopt if the message is malformed.
template <class Message>
std::optional<Message> DecodeAt(const LogReader& log, const LogPlace& place) {
  const auto data = log.Data(place.offset, std::min<int64_t>(place.bytes, kMaxMessageBytes));
  if (!data || !MessageLength(*FindMessageLayout(Message::getTypeName()), *data)) return std::nullopt;
  return Decoded<Message>(*data);
}

/// Messages of one channel without duplicates: by publisher, in the order of their first messages, by number, and by the
/// time of their data (foreign publishers may leave the number at 0). In the log, a repaired message comes after later
/// ones.
class LoggedMessages {
 public:
  void Add(const LogReader::Event& event);
  size_t size() const { return places_.size(); }

  /// Calls `take` for the well-formed messages, in order.
  template <class Message, class Take>
  void ForEach(const LogReader& log, Take take) const {
    for (const auto& [key, place] : places_) {
      if (const auto message = DecodeAt<Message>(log, place)) take(*message);
    }
  }

 private:
  std::vector<SourceId> sources_;
  std::map<std::tuple<size_t, int64_t, int64_t>, LogPlace> places_;  ///< by index of the source, number, and time
};

/// The messages of a log under one prefix.
struct LoggedRobot {
  std::map<std::string_view, LoggedMessages> messages;  ///< by name of the channel
  /// Names of channels with messages of another version of plslam.
  std::set<std::string_view> of_other_versions;
  std::set<std::string_view> visited;  ///< names of channels with messages that are not kept

  const LoggedMessages& On(const Channel& channel) const;
};

/// A channel that a reader of logs needs.
struct IndexedChannel {
  Channel channel;
  int64_t fingerprint;  ///< of its messages in this version
  bool is_kept = true;  ///< false: its messages are only visited
};

/// Reads a log to its end and returns its robots by prefix. `visit` is called, in the order of the log, for messages
/// on channels that are not kept.
std::map<std::string, LoggedRobot> IndexLog(LogReader& log, const std::vector<IndexedChannel>& channels,
                                            const std::function<void(const std::string& prefix, const IndexedChannel&,
                                                                     const LogReader::Event&, LoggedRobot&)>& visit);

}  // namespace plslam::bus
