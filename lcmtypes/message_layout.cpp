// SPDX-License-Identifier: BSD-3-Clause
#include "lcmtypes/message_layout.h"

#include <algorithm>

namespace plslam {

const MessageLayout* FindMessageLayout(std::string_view type) {
  const auto layouts = MessageLayouts();
  const auto row =
      std::find_if(layouts.begin(), layouts.end(), [&](const MessageLayout& l) { return l.name == type; });
  return row == layouts.end() ? nullptr : &*row;
}

}  // namespace plslam
