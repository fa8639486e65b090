// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/names.h"

#include <algorithm>
#include <cctype>

#include "core/ros/ros_topics.h"

namespace plslam::ros2 {
namespace {

constexpr std::string_view kTopicPrefix = "rt";
constexpr std::string_view kTypeFolder = "dds_::";

std::string Replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string result;
  for (size_t at = 0; at <= text.size();) {
    const size_t found = std::min(text.find(from, at), text.size());
    result.append(text.substr(at, found - at));
    if (found == text.size()) break;
    result.append(to);
    at = found + from.size();
  }
  return result;
}

}  // namespace

std::string DdsTopicName(std::string_view topic) { return std::string(kTopicPrefix).append(topic); }

std::string RosTopicName(std::string_view dds_name) {
  const bool is_topic = dds_name.starts_with("rt/");
  return is_topic ? std::string(dds_name.substr(kTopicPrefix.size())) : "";
}

std::string DdsTypeName(std::string_view type) {
  const size_t slash = type.rfind('/');
  return Replaced(type.substr(0, slash + 1), "/", "::")
      .append(kTypeFolder)
      .append(type.substr(slash + 1))
      .append("_");
}

ServiceNames DdsServiceNames(std::string_view service, std::string_view type) {
  const std::string dds_type = DdsTypeName(type);
  return {.request = std::string("rq").append(service).append("Request"),
          .request_type = dds_type + "Request_",
          .reply = std::string("rr").append(service).append("Reply"),
          .reply_type = dds_type + "Response_"};
}

std::string RosTypeName(std::string_view dds_type) {
  const size_t folder = dds_type.find(kTypeFolder);
  if (folder == std::string_view::npos || !dds_type.ends_with("_")) return std::string(dds_type);
  const std::string_view name = dds_type.substr(folder + kTypeFolder.size());
  return Replaced(dds_type.substr(0, folder), "::", "/").append(name.substr(0, name.size() - 1));
}

std::string InNamespace(std::string_view space, std::string_view topic) {
  if (topic.starts_with("/") || space.empty()) {
    return topic.starts_with("/") ? std::string(topic) : std::string("/").append(topic);
  }
  return std::string(space).append(space.ends_with("/") ? "" : "/").append(topic);
}

std::string CameraFrameOf(std::string_view base_frame, std::string_view given) {
  if (!given.empty()) return std::string(given);
  const size_t slash = base_frame.rfind('/');
  const size_t n_prefix = slash == std::string_view::npos ? 0 : slash + 1;
  return std::string(base_frame.substr(0, n_prefix)).append(kRosCamera);
}

std::string TopicNameComplaint(std::string_view topic) {
  if (!topic.starts_with("/")) return "does not begin with /";
  if (topic.size() == 1 || topic.ends_with("/")) return "ends with /";
  for (const char c : topic) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '/' && c != '_') {
      return "has another character than letters, digits, _ and /";
    }
  }
  return "";
}

}  // namespace plslam::ros2
