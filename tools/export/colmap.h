// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/io/maps/map_file.h"
#include "core/io/maps/map_ply.h"

namespace plslam::exports {

/// A feature of an image, in pixels as COLMAP counts them: the centre of the first one is (0.5, 0.5).
struct ColmapFeature {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  /// Of the model's points; -1: none.
  int64_t point_id = -1;
};

struct ColmapImage {
  int64_t id = 0;     ///< from 1
  size_t camera = 0;  ///< of the model's cameras
  SE3 T_c_w;
  std::string name;
  std::vector<ColmapFeature> features;
};

/// Where an image shows a point: index into its features.
struct ColmapView {
  int64_t image_id = 0;
  int32_t feature = 0;
};

struct ColmapPoint {
  int64_t id = 0;  ///< from 1
  Eigen::Vector3d p_w = Eigen::Vector3d::Zero();
  Colour colour{};
  /// Mean distance of its features from where it is projected.
  double error_px = 0.0;
  std::vector<ColmapView> track;
};

/// A sparse model as COLMAP knows it, ordered by id. Cameras (PINHOLE) are that of the map and, where keyframes are from
/// other cameras, what of its image plane those saw.
struct ColmapModel {
  std::vector<StereoCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
};

/// File names of the keyframes' images, by keyframe: the number of the frame, `000012.png`; with the session behind
/// it (`000012_s3.png`) where an earlier keyframe has that name.
std::map<int64_t, std::string> KeyframeImageNames(const Map& map);

/// The keyframes as images and the points seen by two keyframes or more; COLMAP has no line segments, and no stereo
/// that would hold a point seen by one. Numbers are those of the map, plus one. Points lie in the w of the map, in
/// metres.
ColmapModel ColmapOf(const StoredMap& stored, const StereoCamera& camera);

/// Write `cameras`, `images` and `points3D` into the folder, which is made: `.txt`, or `.bin`, which takes precedence
/// for COLMAP. See docs/exports.md. Throw std::runtime_error.
void WriteColmapText(const std::string& folder, const ColmapModel& model);
void WriteColmapBinary(const std::string& folder, const ColmapModel& model);

}  // namespace plslam::exports
