// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/imu_topics.h"

#include <algorithm>
#include <cstddef>

namespace plslam {
namespace {

constexpr std::string_view kRatesEnd = "gyro/sample";
constexpr std::string_view kForcesEnd = "accel/sample";

std::string WithEnd(std::string_view topic, std::string_view end, std::string_view other) {
  return std::string(topic.substr(0, topic.size() - end.size())).append(other);
}

/// Number of leading parts that two names have in common.
size_t SharedParts(std::string_view a, std::string_view b) {
  size_t n = 0;
  for (size_t i = 0; i < a.size() && i < b.size() && a[i] == b[i]; ++i) {
    const bool a_ends = i + 1 == a.size() || a[i + 1] == '/';
    const bool b_ends = i + 1 == b.size() || b[i + 1] == '/';
    n += a[i] != '/' && a_ends && b_ends;
  }
  return n;
}

}  // namespace

ImuTopics ImuTopicsOf(const std::string& topic) {
  if (topic.ends_with(kRatesEnd)) return {topic, WithEnd(topic, kRatesEnd, kForcesEnd)};
  if (topic.ends_with(kForcesEnd)) return {WithEnd(topic, kForcesEnd, kRatesEnd), topic};
  return {topic, topic};
}

std::vector<ImuTopics> ImuTopicsAmong(const std::set<std::string>& topics) {
  std::vector<ImuTopics> complete, apart;
  for (const std::string& topic : topics) {
    const ImuTopics sensor = ImuTopicsOf(topic);
    if (!sensor.are_apart()) {
      complete.push_back(sensor);
    } else if (sensor.rates == topic && topics.contains(sensor.forces)) {
      apart.push_back(sensor);
    }
  }
  complete.insert(complete.end(), apart.begin(), apart.end());
  return complete;
}

ImuTopics NearestImu(const std::vector<ImuTopics>& sensors, std::string_view image_topic) {
  return *std::max_element(sensors.begin(), sensors.end(), [&](const ImuTopics& a, const ImuTopics& b) {
    return SharedParts(a.rates, image_topic) < SharedParts(b.rates, image_topic);
  });
}

}  // namespace plslam
