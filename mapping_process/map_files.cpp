#include "mapping_process/map_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

namespace plslam {
namespace {

// What the map was made with, to the last bit of each number.
struct NamedValue {
  const char* name;
  double value;
};

std::vector<NamedValue> ValuesOf(const StereoCamera& camera) {
  return {{"f_px", camera.f_px},
          {"cx_px", camera.cx_px},
          {"cy_px", camera.cy_px},
          {"baseline_m", camera.baseline_m},
          {"width_px", static_cast<double>(camera.width_px)},
          {"height_px", static_cast<double>(camera.height_px)}};
}

Keyframe KeyframeOf(const MapKeyframe& entry, const StereoFeatures& features, const Map& map) {
  Keyframe keyframe;
  keyframe.session = entry.session;
  keyframe.t_ns = entry.t_ns;
  keyframe.keyframe_id = entry.session_keyframe_id;
  keyframe.frame_id = entry.frame_id;
  const MapKeyframe* previous = map.FindKeyframe(entry.previous_id);
  if (previous != nullptr) keyframe.previous_keyframe_id = previous->session_keyframe_id;
  keyframe.T_prevkf_kf = entry.T_prevkf_kf;
  keyframe.covariance = entry.relative_covariance;
  keyframe.T_odom_kf = entry.T_odom_kf;
  keyframe.state = 1;
  keyframe.features = features;
  keyframe.point_landmark_ids.assign(features.points.size(), -1);
  keyframe.line_landmark_ids.assign(features.lines.size(), -1);
  return keyframe;
}

}  // namespace

std::vector<uint8_t> CameraBytes(const StereoCamera& camera) {
  std::vector<uint8_t> bytes;
  for (const NamedValue& entry : ValuesOf(camera)) {
    const size_t begin = bytes.size();
    bytes.resize(begin + sizeof(entry.value));
    std::memcpy(bytes.data() + begin, &entry.value, sizeof(entry.value));
  }
  return bytes;
}

void CheckCamera(const StoredMap& stored, const StereoCamera& camera, const std::string& path) {
  if (stored.rig.size() != CameraBytes(camera).size()) {
    throw std::runtime_error(fmt::format("{}: says nothing of the camera it was made with", path));
  }
  size_t place = 0;
  for (const NamedValue& entry : ValuesOf(camera)) {
    double value = 0.0;
    std::memcpy(&value, stored.rig.data() + place, sizeof(value));
    place += sizeof(value);
    if (value == entry.value) continue;
    throw std::runtime_error(fmt::format("{}: the map was made with another camera: {} {} instead of {} (rectified)",
                                         path, entry.name, value, entry.value));
  }
}

std::vector<Keyframe> KeyframesOf(const StoredMap& stored) {
  std::vector<Keyframe> keyframes;
  for (const auto& [id, entry] : stored.map.keyframes()) {
    const auto features = stored.features.find(id);
    if (features != stored.features.end()) keyframes.push_back(KeyframeOf(entry, features->second, stored.map));
  }
  return keyframes;
}

}  // namespace plslam
