// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/io/maps/map_file.h"
#include "core/io/maps/map_ply.h"

namespace plslam::exports {

/// A feature of an image, in pixels as COLMAP counts them: the centre of the first one is (0.5, 0.5).
struct ColmapFeature {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  /// Id of one of the model's points; -1: none.
  int64_t point_id = -1;
};

struct ColmapImage {
  int64_t id = 0;     ///< from 1
  size_t camera = 0;  ///< index into the model's cameras
  SE3 T_c_w;
  std::string name;
  std::vector<ColmapFeature> features;
};

/// Observation of a point in an image: index into its features.
struct ColmapView {
  int64_t image_id = 0;
  int32_t feature = 0;
};

struct ColmapPoint {
  int64_t id = 0;  ///< from 1
  Eigen::Vector3d p_w = Eigen::Vector3d::Zero();
  Colour colour{};
  /// Mean distance of its features from its projection.
  double error_px = 0.0;
  std::vector<ColmapView> track;
};

/// A sparse model in COLMAP's terms, ordered by id. Cameras (PINHOLE) are that of the map and, for keyframes of other
/// cameras, the part of its image plane that those cover.
struct ColmapModel {
  std::vector<StereoCamera> cameras;
  std::vector<ColmapImage> images;
  std::vector<ColmapPoint> points;
};

/// Returns the file names of the keyframes' images, by keyframe: the frame id, `000012.png`; followed by the session
/// (`000012_s3.png`) if an earlier keyframe has that name.
std::map<KeyframeId, std::string> KeyframeImageNames(const Map& map);

/// The keyframes become images, with the points observed by two keyframes or more; COLMAP has no line segments, and no
/// stereo for a point observed by one. Ids are those of the map, plus one. Points lie in the w of the map, in metres.
ColmapModel ColmapOf(const StoredMap& stored, const StereoCamera& camera);

/// Write `cameras`, `images` and `points3D` into the folder, which is made: `.txt`, or `.bin`, which takes precedence
/// for COLMAP. See docs/exports.md. Throw std::runtime_error.
void WriteColmapText(const std::string& folder, const ColmapModel& model);
void WriteColmapBinary(const std::string& folder, const ColmapModel& model);

}  // namespace plslam::exports
