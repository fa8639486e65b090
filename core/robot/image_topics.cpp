// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/image_topics.h"

#include <algorithm>
#include <array>

namespace plslam::robot {
namespace {

constexpr auto kCompressed = std::to_array<std::string_view>({"/compressed", "/compressedDepth"});

}  // namespace

bool IsCompressedTopic(std::string_view topic) {
  return std::ranges::any_of(kCompressed, [&](std::string_view end) { return topic.ends_with(end); });
}

std::string InfoTopicOf(std::string_view image_topic) {
  std::string topic(image_topic);
  if (IsCompressedTopic(topic)) topic.resize(topic.rfind('/'));
  const size_t slash = topic.rfind('/');
  if (slash != std::string::npos && topic.compare(slash + 1, 5, "image") == 0) topic.resize(slash);
  return topic + "/camera_info";
}

}  // namespace plslam::robot
