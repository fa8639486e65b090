// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <array>
#include <iterator>
#include <stdexcept>

#include "core/io/files/atomic_file.h"
#include "core/io/files/little_endian.h"
#include "tools/export/colmap_model.h"

namespace plslam {
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

}  // namespace plslam
