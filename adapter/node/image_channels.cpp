// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/image_channels.h"

#include <algorithm>
#include <set>
#include <stdexcept>
#include <string_view>

#include "adapter/node/foreign_layouts.h"
#include "core/bus/transport/stock_lcm.h"

namespace plslam::adapter {

std::vector<std::string> ImageChannels(const std::string& url, std::chrono::milliseconds time) {
  static constexpr std::string_view kTypes[] = {"bot_core.images_t", "sensor_msgs.Image",
                                                "sensor_msgs.CompressedImage"};
  std::set<std::string, std::less<>> channels;
  try {
    bus::ReceiveAll(url, "adapter.foreign_url", time, [&](std::string_view channel, bus::ByteView bytes) {
      const bool is_image = bytes.size() >= 8 && std::ranges::any_of(kTypes, [&](std::string_view type) {
                              return bus::ReadInt64(bytes.data()) == ForeignLayout(type).fingerprint();
                            });
      if (is_image) channels.emplace(channel);
    });
  } catch (const std::runtime_error&) {
    // The subscriptions of `ImageSource` report what cannot be received.
  }
  return {channels.begin(), channels.end()};
}

}  // namespace plslam::adapter
