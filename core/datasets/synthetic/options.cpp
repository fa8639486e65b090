// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/options.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <set>

#include "core/config/nearest_key.h"
#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/inertial_sensor.h"
#include "core/datasets/synthetic/sensor_faults.h"

namespace plslam::synthetic {
namespace {

// Default number of members of a crowd.
constexpr int kCrowd = 20;

struct Bounds {
  double low = 0.0;
  double high = 0.0;
};

/// One row for each numeric option: name, bounds, whether integers only, and its member.
struct NumericOption {
  const char* name;
  Bounds bounds;
  bool whole;
  std::function<void(Options&, double)> set;
};

const std::vector<NumericOption>& NumericOptions() {
  static const std::vector<NumericOption> options = {
      {"seed", {0, 4294967295.0}, true, [](Options& o, double v) { o.seed = static_cast<uint64_t>(v); }},
      {"frames", {1, 1000000}, true, [](Options& o, double v) { o.frames = static_cast<int>(v); }},
      {"loops", {1, 1000}, true, [](Options& o, double v) { o.loops = static_cast<int>(v); }},
      {"changed_after", {1, 1000}, true, [](Options& o, double v) { o.changed_after = static_cast<int>(v); }},
      {"noise", {0, 50}, false, [](Options& o, double v) { o.noise = v; }},
      {"blur", {0, 1}, false, [](Options& o, double v) { o.blur = v; }},
      {"exposure", {0, 3}, false, [](Options& o, double v) { o.exposure = v; }},
      {"baseline", {0.01, 5}, false, [](Options& o, double v) { o.baseline_m = v; }},
      {"fov", {20, 140}, false, [](Options& o, double v) { o.fov_deg = v; }},
      {"rate", {1, 1000}, false, [](Options& o, double v) { o.rate_hz = v; }},
      {"speed", {0.01, 50}, false, [](Options& o, double v) { o.speed = v; }},
      {"distorted", {0, 1}, true, [](Options& o, double v) { o.distorted = v > 0.5; }},
      {"standing", {0, 1}, true, [](Options& o, double v) { o.standing = v > 0.5; }},
      {"turning", {-180, 180}, false, [](Options& o, double v) { o.turning_deg_s = v; }},
      {"bodies", {0, 100}, true, [](Options& o, double v) { o.bodies = static_cast<int>(v); }},
      {"share", {0.05, 1}, false, [](Options& o, double v) { o.share = v; }},
      {"static_body", {0, 0.8}, false, [](Options& o, double v) { o.static_body = v; }},
      {"right_late_ms", {-1000, 1000}, false, [](Options& o, double v) { o.right_late_ms = v; }},
      {"readout_ms", {0, 1000}, false, [](Options& o, double v) { o.readout_ms = v; }},
      {"readout_known", {0, 1}, true, [](Options& o, double v) { o.readout_known = v > 0.5; }},
      {"streaks", {0, 5000}, true, [](Options& o, double v) { o.streaks = static_cast<int>(v); }},
      {"imu", {10, 2000}, false, [](Options& o, double v) { o.imu_rate_hz = v; }},
      {"imu_fault_size", {-20000, 20000}, false, [](Options& o, double v) { o.imu_fault_size = v; }},
      {"dirt", {0, 1000}, true, [](Options& o, double v) { o.dirt = static_cast<int>(v); }},
  };
  return options;
}

/// Wrong letters in a mistyped name; one with more was meant otherwise.
constexpr int kTypo = 2;

std::string Nearest(const std::string& name, const std::vector<std::string>& known) {
  return *std::min_element(known.begin(), known.end(), [&name](const std::string& a, const std::string& b) {
    return EditDistance(name, a) < EditDistance(name, b);
  });
}

std::string Joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) {
    text += (text.empty() ? "" : ", ") + name;
  }
  return text;
}

std::string Shown(double value) {
  std::string text = std::to_string(value);
  text.erase(text.find_last_not_of('0') + 1);
  return text.back() == '.' ? text.substr(0, text.size() - 1) : text;
}

[[noreturn]] void FailUnknown(const std::string& kind, const std::string& name,
                              const std::vector<std::string>& known) {
  const std::string shown = name.substr(0, 40);
  const std::string nearest = Nearest(shown, known);
  const std::string hint = EditDistance(shown, nearest) <= kTypo ? "the nearest is '" + nearest + "', " : "";
  throw DatasetError("synthetic: unknown " + kind + " '" + shown + "'; " + hint + "known are " + Joined(known));
}

double ParseNumber(const NumericOption& option, const std::string& value) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = error == std::errc() && end == value.data() + value.size();
  const bool inside = whole && number >= option.bounds.low && number <= option.bounds.high;  // false for NaN
  if (!inside || (option.whole && static_cast<double>(static_cast<int64_t>(number)) != number)) {
    throw DatasetError("synthetic: option " + std::string(option.name) + "='" + value.substr(0, 40) + "' must be a " +
                       (option.whole ? "whole number" : "number") + " from " + Shown(option.bounds.low) + " to " +
                       Shown(option.bounds.high));
  }
  return number;
}

void ParseSize(const std::string& value, Options& options) {
  const char* end = value.data() + value.size();
  const auto width = std::from_chars(value.data(), end, options.width_px);
  const bool has_cross = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
  const auto height = std::from_chars(has_cross ? width.ptr + 1 : end, end, options.height_px);
  const bool bounded =
      options.width_px >= 32 && options.width_px <= 4096 && options.height_px >= 32 && options.height_px <= 4096;
  if (!has_cross || height.ec != std::errc() || height.ptr != end || !bounded) {
    throw DatasetError("synthetic: option size='" + value.substr(0, 40) +
                       "' must be WIDTHxHEIGHT in pixels, each from 32 to 4096, such as 752x480");
  }
}

void ParseDisparityBias(const std::string& value, Options& options) {
  constexpr double kMost_px = 5.0;
  const char* at = value.data();
  const char* end = at + value.size();
  bool good = true;
  for (size_t i = 0; good && i < options.disparity_bias_px.size(); ++i) {
    double& px = options.disparity_bias_px[i];
    const auto [next, error] = std::from_chars(at, end, px);
    const bool last = i + 1 == options.disparity_bias_px.size();
    good = error == std::errc() && std::abs(px) <= kMost_px && (last ? next == end : next != end && *next == ',');
    at = last ? next : next + 1;
  }
  if (!good) {
    throw DatasetError("synthetic: option disparity_bias='" + value.substr(0, 40) +
                       "' must be three numbers of pixels from -5 to 5, of the left, middle and right third of the "
                       "image, such as 0,0,-0.5");
  }
}

void ParseBody(const std::string& value, Options& options) {
  const std::vector<std::string>& names = BodyNames();
  const auto name = std::find(names.begin(), names.end(), value);
  if (name == names.end()) {
    FailUnknown("body", value, names);
  }
  options.body = static_cast<BodyMotion>(name - names.begin());
}

void ParseImuClass(const std::string& value, Options& options) {
  const std::vector<std::string> names = ImuClassNames();
  if (std::find(names.begin(), names.end(), value) == names.end()) FailUnknown("imu_class", value, names);
  options.imu_class = value;
}

void ParseImuFault(const std::string& value, Options& options) {
  if (FindSensorFault(value) == nullptr) FailUnknown("imu_fault", value, ImuFaultNames());
  options.imu_fault = value;
}

/// Derives the options of the bodies that were not given from those that were.
void CompleteBodies(const std::set<std::string>& given, Options& options) {
  if (!given.contains("bodies")) {
    if (given.contains("share") && !given.contains("body")) {
      throw DatasetError("synthetic: option share= is the size of bodies, but there are none; add bodies=1");
    }
    options.bodies = !given.contains("body") ? 0 : options.body == BodyMotion::kCrowd ? kCrowd : 1;
  }
  if (options.standing && !given.contains("body")) {
    options.body = BodyMotion::kCross;
  }
  if (options.standing && options.body == BodyMotion::kLead) {
    throw DatasetError(
        "synthetic: body=lead moves like the camera, which stands still with standing=1; use body=cross, overtake, "
        "stop "
        "or crowd");
  }
}

void CheckChange(const Options& options) {
  if (options.changed_after == 0) return;
  if (options.world != "room") throw DatasetError("synthetic: option changed_after is of the world room");
  if (options.bodies > 0 || options.static_body > 0.0 || !options.trajectory.empty()) {
    throw DatasetError("synthetic: option changed_after excludes bodies, body, static_body and trajectory");
  }
}

/// Poses of a file are joined by straight lines, which no inertial sensor can measure.
void CheckImu(const std::set<std::string>& given, const Options& options) {
  if (given.contains("imu_class") && !given.contains("imu")) {
    throw DatasetError(
        "synthetic: option imu_class= is the class of an inertial sensor, but there is none; add imu=200");
  }
  if (options.imu_rate_hz > 0.0 && !options.trajectory.empty()) {
    throw DatasetError(
        "synthetic: options imu and trajectory exclude each other, because poses of a file have no accelerations; "
        "leave one out");
  }
}

void CompleteImuFault(const std::set<std::string>& given, Options& options) {
  if (given.contains("imu_fault") && !given.contains("imu")) {
    throw DatasetError(
        "synthetic: option imu_fault= is a fault of an inertial sensor, but there is none; add imu=200");
  }
  const bool has_size = given.contains("imu_fault_size");
  if (has_size && options.imu_fault.empty()) {
    throw DatasetError(
        "synthetic: option imu_fault_size= is the size of a fault, but there is none; add imu_fault=offset");
  }
  if (options.imu_fault.empty()) return;
  const SensorFault& fault = *FindSensorFault(options.imu_fault);
  if (!has_size) options.imu_fault_size = fault.size;
  if (options.imu_fault_size < fault.low || options.imu_fault_size > fault.high) {
    throw DatasetError("synthetic: option imu_fault_size='" + Shown(options.imu_fault_size) + "' of imu_fault=" +
                       fault.name + " must be from " + Shown(fault.low) + " to " + Shown(fault.high));
  }
}

/// Returns the option's name.
std::string ParseOption(const std::string& text, Options& options) {
  const size_t equals = text.find('=');
  std::string name = text.substr(0, equals);
  const std::vector<std::string> known = OptionNames();
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    FailUnknown("option", name, known);
  }
  if (equals == std::string::npos || equals + 1 == text.size()) {
    throw DatasetError("synthetic: option '" + name + "' has no value; write " + name + "=VALUE");
  }
  const std::string value = text.substr(equals + 1);
  if (name == "size") {
    ParseSize(value, options);
  } else if (name == "disparity_bias") {
    ParseDisparityBias(value, options);
  } else if (name == "trajectory") {
    options.trajectory = value;
  } else if (name == "imu_class") {
    ParseImuClass(value, options);
  } else if (name == "imu_fault") {
    ParseImuFault(value, options);
  } else if (name == "body") {
    ParseBody(value, options);
  } else {
    const std::vector<NumericOption>& rows = NumericOptions();
    const auto row = std::find_if(rows.begin(), rows.end(), [&name](const auto& o) { return o.name == name; });
    row->set(options, ParseNumber(*row, value));
  }
  return name;
}

}  // namespace

const std::vector<std::string>& WorldNames() {
  static const std::vector<std::string> names = {"room", "corridor", "street", "whitewall"};
  return names;
}

const std::vector<std::string>& BodyNames() {
  static const std::vector<std::string> names = {"lead", "overtake", "cross", "stop", "crowd"};
  return names;
}

std::vector<std::string> ImuClassNames() {
  std::vector<std::string> names;
  for (const SensorClass& sensor : SensorClasses()) names.push_back(sensor.name);
  return names;
}

std::vector<std::string> ImuFaultNames() {
  std::vector<std::string> names;
  for (const SensorFault& fault : SensorFaults()) names.push_back(fault.name);
  return names;
}

std::vector<std::string> OptionNames() {
  std::vector<std::string> names = {"size", "disparity_bias", "trajectory", "body", "imu_class", "imu_fault"};
  for (const NumericOption& option : NumericOptions()) {
    names.emplace_back(option.name);
  }
  return names;
}

Options ParseOptions(const std::string& description) {
  Options options;
  const size_t question = description.find('?');
  options.world = description.substr(0, question);
  const std::vector<std::string>& worlds = WorldNames();
  if (std::find(worlds.begin(), worlds.end(), options.world) == worlds.end()) {
    FailUnknown("world", options.world, worlds);
  }
  std::set<std::string> given;
  size_t start = question == std::string::npos ? description.size() : question + 1;
  while (start < description.size()) {
    const size_t end = std::min(description.find('&', start), description.size());
    given.insert(ParseOption(description.substr(start, end - start), options));
    start = end + 1;
  }
  CompleteBodies(given, options);
  CheckImu(given, options);
  CompleteImuFault(given, options);
  CheckChange(options);
  return options;
}

}  // namespace plslam::synthetic
