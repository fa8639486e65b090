// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/topic_names.h"

#include <array>

namespace plslam {
namespace {

constexpr std::string_view kDepthPart = "depth";

}  // namespace

bool NamesDepth(std::string_view topic) { return topic.find(kDepthPart) != std::string_view::npos; }

std::vector<std::pair<std::string, std::string>> StereoTopics(const std::set<std::string>& images) {
  static constexpr auto kSides = std::to_array<std::pair<std::string_view, std::string_view>>(
      {{"left", "right"}, {"cam0", "cam1"}, {"infra1", "infra2"}, {"image_0", "image_1"}});
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& topic : images) {
    for (const auto& [left, right] : kSides) {
      const size_t at = topic.find(left);
      if (at == std::string::npos || NamesDepth(topic)) continue;
      std::string partner = topic;
      partner.replace(at, left.size(), right);
      if (images.contains(partner)) pairs.emplace_back(topic, partner);
    }
  }
  return pairs;
}

std::vector<std::pair<std::string, std::string>> RgbdTopics(const std::set<std::string>& images) {
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& topic : images) {
    const size_t at = topic.find(kDepthPart);
    if (at == std::string::npos) continue;
    const std::string space = topic.substr(0, topic.rfind('/', at) + 1);
    const bool is_compressed = topic.ends_with("compressedDepth");
    std::string colour;
    for (const char* name : {"color/", "rgb/"}) {
      const std::string begin = space + name;
      for (auto other = images.lower_bound(begin); other != images.end() && other->starts_with(begin); ++other) {
        const bool same_transport = other->ends_with("/compressed") == is_compressed;
        if (colour.empty() && same_transport && !NamesDepth(*other)) colour = *other;
      }
    }
    if (!colour.empty()) pairs.emplace_back(colour, topic);
  }
  return pairs;
}

}  // namespace plslam
