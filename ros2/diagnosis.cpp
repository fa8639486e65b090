// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/diagnosis.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/config/nearest_key.h"
#include "core/errors/error_text.h"

namespace plslam::ros2 {
namespace {

constexpr double kNsPerMs = 1e6, kNsPerS = 1e9;
/// Stamps further apart are of two clocks: no camera is so late.
constexpr double kOtherClock_s = 1.0;

std::string Topics(const std::set<std::string>& names) {
  constexpr size_t kMost = 8;
  std::vector<std::string> shown;
  for (const std::string& name : names) {
    if (shown.size() < kMost) shown.push_back(Shown(name));
  }
  if (names.size() > kMost) shown.push_back(fmt::format("and {} more", names.size() - kMost));
  return fmt::format("{}", fmt::join(shown, ", "));
}

/// Why nothing arrives on a topic; empty if something does.
std::string WhySilent(const Input& input, const Symptoms& symptoms) {
  if (input.state.n_messages > 0) return "";
  const auto is_like = [&](const std::string& type) {
    return type == input.type || (IsImageType(type) && IsImageType(input.type));
  };
  std::set<std::string> types, likely, all;
  for (const Publisher& publisher : symptoms.publishers) {
    if (publisher.topic == input.topic) types.insert(publisher.type);
    if (is_like(publisher.type)) likely.insert(publisher.topic);
    all.insert(publisher.topic);
  }
  if (types.empty()) {
    const std::set<std::string>& others = likely.empty() ? all : likely;
    return fmt::format("no topic {} in the domain {}; {} {}; the nearest name is {}", input.topic, symptoms.domain,
                       likely.empty() ? "there is none of its type, but" : "topics of its type are", Topics(others),
                       Shown(NearestKey(input.topic, {others.begin(), others.end()})));
  }
  if (!types.contains(input.type)) {
    return fmt::format("{} has the type {}, not {}", input.topic, Topics(types), input.type);
  }
  if (input.state.n_publishers == 0 && !input.state.incompatible_qos.empty()) {
    return fmt::format("the publisher of {} has an incompatible quality of service ({})", input.topic,
                       input.state.incompatible_qos);
  }
  if (input.state.n_publishers == 0) return fmt::format("{} was found, and is not connected yet", input.topic);
  return fmt::format(
      "{} has a publisher, but nothing arrives: it sends nothing, or large messages are lost (sysctl -w "
      "net.core.rmem_max=16777216)",
      input.topic);
}

/// Why no two images are a pair, whatever they show; empty if their stamps may be right.
std::string WrongStamps(const Symptoms& symptoms) {
  for (const Input* input : {&symptoms.left, &symptoms.right}) {
    if (input->stamp_ns && input->previous_stamp_ns && *input->stamp_ns == *input->previous_stamp_ns) {
      return fmt::format("the stamps of {} are all {} s: its driver must set them", input->topic,
                         static_cast<double>(*input->stamp_ns) / kNsPerS);
    }
  }
  if (!symptoms.left.stamp_ns || !symptoms.right.stamp_ns) return "";
  const double apart_ms =
      std::abs(static_cast<double>(*symptoms.left.stamp_ns - *symptoms.right.stamp_ns)) / kNsPerMs;
  if (apart_ms > 1e3 * kOtherClock_s) {
    return fmt::format("the stamps of {} and {} are {:.3f} s apart: they are of two clocks", symptoms.left.topic,
                       symptoms.right.topic, 1e-3 * apart_ms);
  }
  return "";
}

std::string Unsynchronised(const Symptoms& symptoms) {
  if (!symptoms.left.stamp_ns || !symptoms.right.stamp_ns) return "";
  return fmt::format(
      "no image of {} has the stamp of one of {} within {} ms (ros2.max_skew_ms): the cameras are not synchronised",
      symptoms.left.topic, symptoms.right.topic, symptoms.max_skew_ms);
}

}  // namespace

bool IsImageType(const std::string& type) {
  return type == "sensor_msgs/msg/Image" || type == "sensor_msgs/msg/CompressedImage";
}

std::string WhyNoFrames(const Symptoms& symptoms) {
  if (symptoms.publishers.empty()) {
    return fmt::format(
        "no publisher of ROS 2 was found in the domain {}: none runs, it is in another domain (ROS_DOMAIN_ID), or "
        "the "
        "network carries no multicast",
        symptoms.domain);
  }
  const std::string left = WhySilent(symptoms.left, symptoms), right = WhySilent(symptoms.right, symptoms);
  if (!left.empty() && !right.empty()) return left == right ? left : left + "; and " + right;
  if (!left.empty()) return fmt::format("{} arrives without left images: {}", symptoms.right.topic, left);
  if (!right.empty()) return fmt::format("{} arrives without right images: {}", symptoms.left.topic, right);
  if (!symptoms.has_rig) {
    for (const Input& info : symptoms.infos) {
      const std::string reason = WhySilent(info, symptoms);
      if (!reason.empty()) return fmt::format("images arrive without CameraInfo: {}; or give --camera FILE", reason);
    }
  }
  std::string wrong = WrongStamps(symptoms);
  if (!wrong.empty()) return wrong;
  return symptoms.n_rejected > 0 ? "no image could be used: see the log" : Unsynchronised(symptoms);
}

std::set<std::string> ImageTopics(const std::vector<Publisher>& publishers) {
  std::set<std::string> images;
  for (const Publisher& publisher : publishers) {
    if (IsImageType(publisher.type)) images.insert(publisher.topic);
  }
  return images;
}

}  // namespace plslam::ros2
