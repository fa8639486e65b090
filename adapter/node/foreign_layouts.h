// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>
#include <string_view>

#include "lcmtypes/message_layout.h"

namespace plslam {

/// All types of lcmtypes/foreign/, by package and name ("sensor_msgs.Image"). Generated from the .lcm files.
std::span<const MessageLayout> ForeignLayouts();

/// Row of a type that is there.
inline const MessageLayout& ForeignLayout(std::string_view type) {
  for (const MessageLayout& layout : ForeignLayouts()) {
    if (layout.name == type) return layout;
  }
  throw std::invalid_argument("no foreign type " + std::string(type));
}

}  // namespace plslam
