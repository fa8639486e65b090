// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "core/bus/channels.h"
#include "core/bus/options.h"

namespace plslam::bus {

/// What channels are called on the wire. Each robot has a prefix, and robots that share a map have a second one in
/// common (`Scope` says which channels use it).
class ChannelNames {
 public:
  /// Throws std::runtime_error with one sentence where a prefix is too long or has odd characters.
  explicit ChannelNames(const BusOptions& options);

  /// Of where channels of that scope are published, and requests and announcements about them.
  const std::string& PrefixOf(Scope scope) const { return scope == Scope::kMap ? map_prefix_ : prefix_; }
  /// Where the channel is published, and (all but kFromMap) read.
  std::string WireName(const Channel& channel) const;
  /// The same under the map's prefix; empty where that is the same name.
  std::string NameForMap(const Channel& channel) const;
  /// Whether `wire_name` is the channel under the one or the other prefix.
  bool IsNamed(std::string_view wire_name, const Channel& channel) const;
  /// Whether a request or announcement (`control`) that came as `wire_name` can speak of our `channel`. Control
  /// messages hold names without prefix: what comes under the map's prefix may be about the same channel of another
  /// robot, or of the map's owner.
  bool IsAbout(const Channel& channel, std::string_view wire_name, const Channel& control) const;

 private:
  std::string prefix_;
  std::string map_prefix_;
};

}  // namespace plslam::bus
