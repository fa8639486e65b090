// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

#include "core/bus/bus.h"
#include "core/bus/messages/map_channel.h"
#include "core/bus/messages/map_pages.h"
#include "core/bus/transport/transport.h"
#include "core/map/map_follower.h"
#include "core/map/map_update.h"
#include "plslam/map_update_t.hpp"

namespace plslam::test {

/// Decodes bytes of a recording; throws std::runtime_error if they are damaged.
template <class Message>
Message MessageOf(bus::ByteView bytes) {
  const std::optional<Message> message = bus::Decoded<Message>(bytes);
  if (!message) throw std::runtime_error(std::string("the log has a damaged ") + Message::getTypeName());
  return *message;
}

/// All but the URL by default.
bus::BusOptions BusOptionsFor(const std::string& url);

/// A process that a test plays: publishes the messages of that process in a log, on its own bus.
///
/// The last message on a channel whose newest message wins (CAMERA, STATUS) is repeated until there is a newer one. Its
/// map is published as by mapping_process: also as a complete map for listeners that lack it.
class PlayedProcess {
 public:
  PlayedProcess(const bus::BusOptions& options, const std::string& name);
  ~PlayedProcess();
  PlayedProcess(const PlayedProcess&) = delete;
  PlayedProcess& operator=(const PlayedProcess&) = delete;

  SourceId source() const { return bus_.source(); }

  /// `message` is encoded, of the type of `channel`.
  void Say(const bus::Channel& channel, bus::ByteView message);
  /// Publishes the complete map if it was requested. Called on the thread that calls `Say`.
  void AnswerMapRequests();

 private:
  void SayMap(const map_update_t& page);

  bus::Bus bus_;
  std::mutex mutex_;
  std::map<std::string_view, std::pair<const bus::Channel*, std::vector<uint8_t>>> newest_;  // by channel
  std::atomic<bool> map_is_asked_for_{false};
  bus::MapUpdatePublisher map_publisher_;
  bus::MapUpdateAssembler assembler_;
  MapFollower map_;
  MapUpdate last_update_;
  std::thread thread_;
};

/// Sends each datagram of some processes once more, as a network may.
class Doubler {
 public:
  /// The processes are named by `Bus::source`.
  Doubler(const std::string& url, std::set<SourceId> sources);
  ~Doubler();
  Doubler(const Doubler&) = delete;
  Doubler& operator=(const Doubler&) = delete;

 private:
  void Double(std::string_view channel, bus::ByteView bytes);

  const std::set<SourceId> sources_;
  bus::Transport transport_;
  std::set<std::tuple<std::string, SourceId, int64_t>> doubled_;  ///< channel, publisher, number
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

}  // namespace plslam::test
