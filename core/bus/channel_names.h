// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "core/bus/channels.h"
#include "core/bus/options.h"

namespace plslam::bus {

/// Names of the channels on the wire. Each robot has a prefix, and robots that share a map have a second one in common
/// (`Scope` determines which channels use it).
class ChannelNames {
 public:
  /// Throws std::runtime_error with one sentence if a prefix is too long or has invalid characters.
  explicit ChannelNames(const BusOptions& options);

  /// Returns the prefix under which channels of this scope are published, and requests and announcements about them.
  const std::string& PrefixOf(Scope scope) const { return scope == Scope::kMap ? map_prefix_ : prefix_; }
  /// Returns the name under which the channel is published and (except for kFromMap) read.
  std::string WireName(const Channel& channel) const;
  /// Returns the name under the map's prefix; empty if it is the same name.
  std::string NameForMap(const Channel& channel) const;
  /// Returns whether `wire_name` is the channel under either prefix.
  bool IsNamed(std::string_view wire_name, const Channel& channel) const;
  /// Returns whether a request or announcement (`control`) that arrived as `wire_name` can refer to our `channel`.
  /// Control messages hold names without prefix: under the map's prefix they may refer to the same channel of another
  /// robot, or of the map's owner.
  bool IsAbout(const Channel& channel, std::string_view wire_name, const Channel& control) const;

 private:
  std::string prefix_;
  std::string map_prefix_;
};

}  // namespace plslam::bus
