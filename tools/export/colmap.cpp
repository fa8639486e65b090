// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/colmap.h"

#include <array>
#include <iterator>
#include <set>
#include <stdexcept>

#include <fmt/format.h>

#include "core/io/files/atomic_file.h"
#include "core/io/files/bytes.h"

namespace plslam::exports {
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

namespace {

constexpr uint32_t kCameraId = 1;
/// COLMAP's number of the model PINHOLE (fx, fy, cx, cy).
constexpr int32_t kPinhole = 1;
constexpr uint64_t kNoPoint = ~uint64_t{0};

double CentreX(const StereoCamera& camera) { return camera.cx_px + 0.5; }
double CentreY(const StereoCamera& camera) { return camera.cy_px + 0.5; }

/// qw qx qy qz tx ty tz, zeros without sign.
std::array<double, 7> PoseNumbers(const ColmapImage& image) {
  const Eigen::Quaterniond& q = image.T_c_w.rotation();
  const Eigen::Vector3d& t = image.T_c_w.translation();
  return {q.w() + 0.0, q.x() + 0.0, q.y() + 0.0, q.z() + 0.0, t.x() + 0.0, t.y() + 0.0, t.z() + 0.0};
}

std::string CamerasText(const ColmapModel& model) {
  const StereoCamera& c = model.camera;
  return fmt::format(
      "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n{} PINHOLE {} {} {:.17g} {:.17g} {:.17g} {:.17g}\n", kCameraId,
      c.width_px, c.height_px, c.f_px, c.f_px, CentreX(c), CentreY(c));
}

std::string ImagesText(const ColmapModel& model) {
  std::string text = "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, POINT3D_ID)\n";
  const auto out = std::back_inserter(text);
  for (const ColmapImage& image : model.images) {
    fmt::format_to(out, "{}", image.id);
    for (const double value : PoseNumbers(image)) fmt::format_to(out, " {:.17g}", value);
    fmt::format_to(out, " {} {}\n", kCameraId, image.name);
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
  const StereoCamera& c = model.camera;
  std::string bytes;
  AppendLittleEndian(uint64_t{1}, bytes);
  AppendLittleEndian(kCameraId, bytes);
  AppendLittleEndian(kPinhole, bytes);
  AppendLittleEndian(static_cast<uint64_t>(c.width_px), bytes);
  AppendLittleEndian(static_cast<uint64_t>(c.height_px), bytes);
  for (const double value : {c.f_px, c.f_px, CentreX(c), CentreY(c)}) AppendLittleEndian(value, bytes);
  return bytes;
}

void AppendImage(const ColmapImage& image, std::string& bytes) {
  AppendLittleEndian(static_cast<uint32_t>(image.id), bytes);
  for (const double value : PoseNumbers(image)) AppendLittleEndian(value, bytes);
  AppendLittleEndian(kCameraId, bytes);
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
