// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/channel_names.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

namespace plslam::bus {
namespace {

void CheckPrefix(const std::string& key, const std::string& prefix) {
  const bool plain = std::all_of(prefix.begin(), prefix.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '/' || c == '.';
  });
  if (!plain || prefix.size() > 32) {
    throw std::runtime_error("bus." + key + ": '" + prefix + "' must be at most 32 letters, digits or _ - / .");
  }
}

}  // namespace

ChannelNames::ChannelNames(const BusOptions& options)
    : prefix_(options.prefix), map_prefix_(options.map_prefix.empty() ? options.prefix : options.map_prefix) {
  CheckPrefix("prefix", options.prefix);
  CheckPrefix("map_prefix", options.map_prefix);
}

std::string ChannelNames::WireName(const Channel& channel) const {
  return std::string(PrefixOf(channel.scope)).append(channel.name);
}

std::string ChannelNames::NameForMap(const Channel& channel) const {
  const std::string name = std::string(map_prefix_).append(channel.name);
  return name == WireName(channel) ? std::string() : name;
}

bool ChannelNames::IsNamed(std::string_view wire_name, const Channel& channel) const {
  if (!wire_name.ends_with(channel.name)) return false;
  const std::string_view prefix = wire_name.substr(0, wire_name.size() - channel.name.size());
  return prefix == prefix_ || prefix == map_prefix_;
}

bool ChannelNames::IsAbout(const Channel& channel, std::string_view wire_name, const Channel& control) const {
  const std::string& prefix = PrefixOf(channel.scope);
  return wire_name.size() == prefix.size() + control.name.size() && wire_name.starts_with(prefix);
}

}  // namespace plslam::bus
