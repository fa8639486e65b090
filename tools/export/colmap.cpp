// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/colmap.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "core/files/atomic_file.h"
#include "core/files/bytes.h"

namespace plslam::exports {
namespace {

const Eigen::Vector2d kHalfPixel(0.5, 0.5);
constexpr double kLeastDepth_m = 1e-6;

/// Pixels of the image plane that images of this camera begin at.
Eigen::Vector2d Begin(const StereoCamera& camera) { return Eigen::Vector2d(camera.left_px, camera.top_px); }

/// Returns the index of the camera with this image; a new one is added.
size_t CameraWith(const StereoCamera& camera, std::vector<StereoCamera>& cameras) {
  const auto found = std::find(cameras.begin(), cameras.end(), camera);
  if (found != cameras.end()) return static_cast<size_t>(found - cameras.begin());
  cameras.push_back(camera);
  return cameras.size() - 1;
}

ColmapImage ImageOf(const MapKeyframe& keyframe, const std::string& name, const FeaturesView& features,
                    std::vector<StereoCamera>& cameras) {
  const size_t camera = features.image ? CameraWith(CameraOf(features, cameras.front()), cameras) : 0;
  ColmapImage image{keyframe.id.value + 1, camera, keyframe.T_w_kf.Inverse(), name, {}};
  image.features.reserve(features.points.size());
  const Eigen::Vector2d shift = kHalfPixel - Begin(cameras[camera]);
  for (const StereoPoint& point : features.points) image.features.push_back({point.left.px + shift, -1});
  return image;
}

/// The views of a point by images that have the feature.
std::vector<ColmapView> TrackOf(const MapPoint& point, const std::vector<ColmapImage>& images,
                                const std::map<KeyframeId, size_t>& place_of) {
  std::vector<ColmapView> track;
  for (const Observation& observation : point.observations) {
    const auto place = place_of.find(observation.keyframe_id());
    if (place == place_of.end()) continue;
    const ColmapImage& image = images[place->second];
    if (observation.feature < static_cast<int64_t>(image.features.size()))
      track.push_back({image.id, observation.feature});
  }
  return track;
}

double ErrorOf(const ColmapPoint& point, const ColmapModel& model, const std::map<KeyframeId, size_t>& place_of) {
  double sum = 0.0;
  int n = 0;
  for (const ColmapView& view : point.track) {
    const ColmapImage& image = model.images[place_of.at(KeyframeId(view.image_id - 1))];
    const Eigen::Vector3d p_c = image.T_c_w * point.p_w;
    if (p_c.z() < kLeastDepth_m) continue;
    const size_t feature = static_cast<size_t>(view.feature);
    const StereoCamera& camera = model.cameras[image.camera];
    sum += (camera.Project(p_c) + kHalfPixel - Begin(camera) - image.features[feature].px).norm();
    ++n;
  }
  return n > 0 ? sum / n : 0.0;
}

void AddPoint(const MapPoint& point, const Colour& colour, const std::map<KeyframeId, size_t>& place_of,
              ColmapModel& model) {
  ColmapPoint entry{point.id.value + 1, point.p_w, colour, 0.0, TrackOf(point, model.images, place_of)};
  if (entry.track.size() < 2) return;
  entry.error_px = ErrorOf(entry, model, place_of);
  for (const ColmapView& view : entry.track) {
    model.images[place_of.at(KeyframeId(view.image_id - 1))].features[static_cast<size_t>(view.feature)].point_id =
        entry.id;
  }
  model.points.push_back(std::move(entry));
}

}  // namespace

std::map<KeyframeId, std::string> KeyframeImageNames(const Map& map) {
  std::map<KeyframeId, std::string> names;
  std::set<FrameId> taken;
  for (const auto& [id, keyframe] : map.keyframes()) {
    const bool first = taken.insert(keyframe.frame_id).second;
    names[id] = first ? fmt::format("{:06}.png", keyframe.frame_id)
                      : fmt::format("{:06}_s{}.png", keyframe.frame_id, keyframe.name.session);
  }
  return names;
}

ColmapModel ColmapOf(const StoredMap& stored, const StereoCamera& camera) {
  ColmapModel model{{camera}, {}, {}};
  const auto names = KeyframeImageNames(stored.map);
  const KeptFeatures none;
  std::map<KeyframeId, size_t> place_of;
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    const auto features = stored.features.find(id);
    place_of[id] = model.images.size();
    model.images.push_back(
        ImageOf(keyframe, names.at(id), features == stored.features.end() ? none : features->second, model.cameras));
  }
  const HeightColours colour_of(stored.map);
  for (const auto& [id, point] : stored.map.points()) AddPoint(point, colour_of(point.p_w), place_of, model);
  return model;
}

namespace {

/// From 1.
uint32_t CameraId(size_t camera) { return static_cast<uint32_t>(camera + 1); }
/// COLMAP's number of the model PINHOLE (fx, fy, cx, cy).
constexpr int32_t kPinhole = 1;
constexpr uint64_t kNoPoint = ~uint64_t{0};

Eigen::Vector2d Centre(const StereoCamera& camera) {
  return Eigen::Vector2d(camera.cx_px, camera.cy_px) + kHalfPixel - Begin(camera);
}

/// Returns qw qx qy qz tx ty tz, zeros without sign.
std::array<double, 7> PoseNumbers(const ColmapImage& image) {
  const Eigen::Quaterniond& q = image.T_c_w.rotation();
  const Eigen::Vector3d& t = image.T_c_w.translation();
  return {q.w() + 0.0, q.x() + 0.0, q.y() + 0.0, q.z() + 0.0, t.x() + 0.0, t.y() + 0.0, t.z() + 0.0};
}

std::string CamerasText(const ColmapModel& model) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (size_t i = 0; i < model.cameras.size(); ++i) {
    const StereoCamera& c = model.cameras[i];
    text += fmt::format("{} PINHOLE {} {} {:.17g} {:.17g} {:.17g} {:.17g}\n", CameraId(i), c.width_px, c.height_px,
                        c.f_px, c.f_px, Centre(c).x(), Centre(c).y());
  }
  return text;
}

std::string ImagesText(const ColmapModel& model) {
  std::string text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  const auto out = std::back_inserter(text);
  for (const ColmapImage& image : model.images) {
    fmt::format_to(out, "{}", image.id);
    for (const double value : PoseNumbers(image)) fmt::format_to(out, " {:.17g}", value);
    fmt::format_to(out, " {} {}\n", CameraId(image.camera), image.name);
    const char* space = "";
    for (const ColmapFeature& feature : image.features) {
      fmt::format_to(out, "{}{:.17g} {:.17g} {}", space, feature.px.x(), feature.px.y(), feature.point_id);
      space = " ";
    }
    text += '\n';
  }
  return text;
}

std::string PointsText(const ColmapModel& model) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  const auto out = std::back_inserter(text);
  for (const ColmapPoint& point : model.points) {
    fmt::format_to(out, "{} {:.17g} {:.17g} {:.17g} {} {} {} {:.17g}", point.id, point.p_w.x(), point.p_w.y(),
                   point.p_w.z(), point.colour[0], point.colour[1], point.colour[2], point.error_px);
    for (const ColmapView& view : point.track) fmt::format_to(out, " {} {}", view.image_id, view.feature);
    text += '\n';
  }
  return text;
}

std::string CamerasBytes(const ColmapModel& model) {
  std::string bytes;
  AppendLittleEndian(static_cast<uint64_t>(model.cameras.size()), bytes);
  for (size_t i = 0; i < model.cameras.size(); ++i) {
    const StereoCamera& c = model.cameras[i];
    AppendLittleEndian(CameraId(i), bytes);
    AppendLittleEndian(kPinhole, bytes);
    AppendLittleEndian(static_cast<uint64_t>(c.width_px), bytes);
    AppendLittleEndian(static_cast<uint64_t>(c.height_px), bytes);
    for (const double value : {c.f_px, c.f_px, Centre(c).x(), Centre(c).y()}) AppendLittleEndian(value, bytes);
  }
  return bytes;
}

void AppendImage(const ColmapImage& image, std::string& bytes) {
  AppendLittleEndian(static_cast<uint32_t>(image.id), bytes);
  for (const double value : PoseNumbers(image)) AppendLittleEndian(value, bytes);
  AppendLittleEndian(CameraId(image.camera), bytes);
  bytes.append(image.name.c_str(), image.name.size() + 1);
  AppendLittleEndian(static_cast<uint64_t>(image.features.size()), bytes);
  for (const ColmapFeature& feature : image.features) {
    AppendLittleEndian(feature.px.x(), bytes);
    AppendLittleEndian(feature.px.y(), bytes);
    AppendLittleEndian(feature.point_id < 0 ? kNoPoint : static_cast<uint64_t>(feature.point_id), bytes);
  }
}

std::string ImagesBytes(const ColmapModel& model) {
  std::string bytes;
  AppendLittleEndian(static_cast<uint64_t>(model.images.size()), bytes);
  for (const ColmapImage& image : model.images) AppendImage(image, bytes);
  return bytes;
}

void AppendPoint(const ColmapPoint& point, std::string& bytes) {
  AppendLittleEndian(static_cast<uint64_t>(point.id), bytes);
  for (const double value : point.p_w) AppendLittleEndian(value, bytes);
  for (const uint8_t channel : point.colour) AppendLittleEndian(channel, bytes);
  AppendLittleEndian(point.error_px, bytes);
  AppendLittleEndian(static_cast<uint64_t>(point.track.size()), bytes);
  for (const ColmapView& view : point.track) {
    AppendLittleEndian(static_cast<uint32_t>(view.image_id), bytes);
    AppendLittleEndian(static_cast<uint32_t>(view.feature), bytes);
  }
}

std::string PointsBytes(const ColmapModel& model) {
  std::string bytes;
  AppendLittleEndian(static_cast<uint64_t>(model.points.size()), bytes);
  for (const ColmapPoint& point : model.points) AppendPoint(point, bytes);
  return bytes;
}

}  // namespace

void WriteColmapText(const std::string& folder, const ColmapModel& model) {
  MakeFolder(folder);
  WriteFileAtomically(folder + "/cameras.txt", CamerasText(model));
  WriteFileAtomically(folder + "/images.txt", ImagesText(model));
  WriteFileAtomically(folder + "/points3D.txt", PointsText(model));
}

void WriteColmapBinary(const std::string& folder, const ColmapModel& model) {
  MakeFolder(folder);
  WriteFileAtomically(folder + "/cameras.bin", CamerasBytes(model));
  WriteFileAtomically(folder + "/images.bin", ImagesBytes(model));
  WriteFileAtomically(folder + "/points3D.bin", PointsBytes(model));
}

}  // namespace plslam::exports
