// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/colmap_model.h"

#include <fmt/format.h>

#include <set>

namespace plslam {
namespace {

const Eigen::Vector2d kHalfPixel(0.5, 0.5);
constexpr double kLeastDepth_m = 1e-6;

ColmapImage ImageOf(const MapKeyframe& keyframe, const std::string& name, const StereoFeatures& features) {
  ColmapImage image{keyframe.id + 1, keyframe.T_w_kf.Inverse(), name, {}};
  image.features.reserve(features.points.size());
  for (const StereoPoint& point : features.points) image.features.push_back({point.left.px + kHalfPixel, -1});
  return image;
}

/// The views of a point by images that have the feature.
std::vector<ColmapView> TrackOf(const MapPoint& point, const std::vector<ColmapImage>& images,
                                const std::map<int64_t, size_t>& place_of) {
  std::vector<ColmapView> track;
  for (const Observation& observation : point.observations) {
    const auto place = place_of.find(observation.keyframe_id);
    if (place == place_of.end()) continue;
    const ColmapImage& image = images[place->second];
    if (observation.feature < static_cast<int64_t>(image.features.size()))
      track.push_back({image.id, observation.feature});
  }
  return track;
}

double ErrorOf(const ColmapPoint& point, const ColmapModel& model, const std::map<int64_t, size_t>& place_of) {
  double sum = 0.0;
  int n = 0;
  for (const ColmapView& view : point.track) {
    const ColmapImage& image = model.images[place_of.at(view.image_id - 1)];
    const Eigen::Vector3d p_c = image.T_c_w * point.p_w;
    if (p_c.z() < kLeastDepth_m) continue;
    const size_t feature = static_cast<size_t>(view.feature);
    sum += (model.camera.Project(p_c) + kHalfPixel - image.features[feature].px).norm();
    ++n;
  }
  return n > 0 ? sum / n : 0.0;
}

void AddPoint(const MapPoint& point, const Colour& colour, const std::map<int64_t, size_t>& place_of,
              ColmapModel& model) {
  ColmapPoint entry{point.id + 1, point.p_w, colour, 0.0, TrackOf(point, model.images, place_of)};
  if (entry.track.size() < 2) return;
  entry.error_px = ErrorOf(entry, model, place_of);
  for (const ColmapView& view : entry.track) {
    model.images[place_of.at(view.image_id - 1)].features[static_cast<size_t>(view.feature)].point_id = entry.id;
  }
  model.points.push_back(std::move(entry));
}

}  // namespace

std::map<int64_t, std::string> KeyframeImageNames(const Map& map) {
  std::map<int64_t, std::string> names;
  std::set<int64_t> taken;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const bool first = taken.insert(keyframe.frame_id).second;
    names[id] = first ? fmt::format("{:06}.png", keyframe.frame_id)
                      : fmt::format("{:06}_s{}.png", keyframe.frame_id, keyframe.session);
  }
  return names;
}

ColmapModel ColmapOf(const StoredMap& stored, const StereoCamera& camera) {
  ColmapModel model{camera, {}, {}};
  const auto names = KeyframeImageNames(stored.map);
  const StereoFeatures none;
  std::map<int64_t, size_t> place_of;
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    const auto features = stored.features.find(id);
    place_of[id] = model.images.size();
    model.images.push_back(
        ImageOf(keyframe, names.at(id), features == stored.features.end() ? none : features->second));
  }
  const HeightColours colour_of(stored.map);
  for (const auto& [id, point] : stored.map.points()) AddPoint(point, colour_of(point.p_w), place_of, model);
  return model;
}

}  // namespace plslam
