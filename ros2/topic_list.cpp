// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/topic_list.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/imu_topics.h"
#include "core/datasets/recordings/ros_messages.h"
#include "core/datasets/recordings/topic_names.h"
#include "core/errors/error_text.h"

namespace plslam::ros2 {
namespace {

/// Returns the option for the inertial sensor beside these images, after a blank; empty if there is none.
std::string ImuOption(const std::vector<Publisher>& publishers, const std::string& left) {
  std::set<std::string> topics;
  for (const Publisher& publisher : publishers) {
    if (publisher.type == kRosImu) topics.insert(publisher.topic);
  }
  const std::vector<ImuTopics> sensors = ImuTopicsAmong(topics);
  return sensors.empty() ? "" : fmt::format(" --set ros2.imu={}", Shown(NearestImu(sensors, left).rates));
}

}  // namespace

std::string TopicTable(const std::vector<Publisher>& publishers, const std::map<std::string, HeardImages>& heard,
                       double listened_s, int domain) {
  std::map<std::pair<std::string, std::string>, std::vector<Publisher>> topics;
  for (const Publisher& publisher : publishers) topics[{publisher.topic, publisher.type}].push_back(publisher);
  std::string text = fmt::format("{} topics in the domain {}\n", topics.size(), domain);
  size_t widest = 0;
  for (const auto& [topic, of_it] : topics) widest = std::max(widest, Shown(topic.first).size());
  for (const auto& [topic, of_it] : topics) {
    const Publisher& first = of_it.front();
    text += fmt::format("{:<{}}  {}  {} publisher{}, {}, {}", Shown(topic.first), widest, Shown(topic.second),
                        of_it.size(), of_it.size() == 1 ? "" : "s", first.is_reliable ? "reliable" : "best effort",
                        first.is_latched ? "transient local" : "volatile");
    const auto images = heard.find(topic.first);
    if (images != heard.end() && images->second.n > 0) {
      const HeardImages& h = images->second;
      text += fmt::format(
          ", {:.1f} Hz, {:.1f} MB/s, {}", static_cast<double>(h.n) / listened_s,
          1e-6 * static_cast<double>(h.bytes) / listened_s,
          h.encoding.empty() ? "compressed" : fmt::format("{} x {} {}", h.width_px, h.height_px, Shown(h.encoding)));
    } else if (images != heard.end()) {
      text += ", nothing heard";
    }
    text += "\n";
  }
  const std::set<std::string> images = ImageTopics(publishers);
  const auto list = [&](const char* title, const std::vector<std::pair<std::string, std::string>>& pairs) {
    if (!pairs.empty()) text += title;
    for (const auto& [left, right] : pairs)
      text += fmt::format("  plslam run ros2:{},{}{}\n", Shown(left), Shown(right), ImuOption(publishers, left));
  };
  list("\nStereo cameras:\n", StereoTopics(images));
  list("\nRGB-D cameras:\n", RgbdTopics(images));
  return text;
}

}  // namespace plslam::ros2
