// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/topic_names.h"

#include <array>

namespace plslam {
namespace {

constexpr std::string_view kDepthPart = "depth";

/// Returns how often a name, or its part from `at` on, contains "depth".
int CountDepth(std::string_view name, size_t at = 0) {
  int n = 0;
  for (at = name.find(kDepthPart, at); at != name.npos; at = name.find(kDepthPart, at + kDepthPart.size())) ++n;
  return n;
}

}  // namespace

bool NamesDepth(std::string_view left, std::string_view right) { return CountDepth(right) > CountDepth(left); }

std::vector<std::pair<std::string, std::string>> StereoTopics(const std::set<std::string>& images) {
  static constexpr auto kSides = std::to_array<std::pair<std::string_view, std::string_view>>(
      {{"left", "right"}, {"cam0", "cam1"}, {"infra1", "infra2"}, {"image_0", "image_1"}});
  std::vector<std::pair<std::string, std::string>> pairs;
  for (const std::string& topic : images) {
    for (const auto& [left, right] : kSides) {
      const size_t at = topic.find(left);
      // Depths of both sides ("left/depth") are no pair of images; the name of the camera before them has no meaning.
      if (at == std::string::npos || CountDepth(topic, topic.rfind('/', at) + 1) > 0) continue;
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
    const bool is_compressed = topic.ends_with("compressedDepth");
    std::string colour;
    // A part before may be the name of the camera ("/depth_camera/depth").
    for (size_t at = topic.find(kDepthPart); at != topic.npos; at = topic.find(kDepthPart, at + kDepthPart.size())) {
      const std::string space = topic.substr(0, topic.rfind('/', at) + 1);
      for (const char* name : {"color/", "rgb/"}) {
        const std::string begin = space + name;
        for (auto other = images.lower_bound(begin); other != images.end() && other->starts_with(begin); ++other) {
          const bool same_transport = other->ends_with("/compressed") == is_compressed;
          if (colour.empty() && same_transport && CountDepth(*other, begin.size()) == 0) colour = *other;
        }
      }
    }
    if (!colour.empty()) pairs.emplace_back(colour, topic);
  }
  return pairs;
}

}  // namespace plslam
