// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/config/choices.h"
#include "core/map/map.h"

namespace plslam {

/// The measurements that a vertical comes from.
enum class VerticalSource {
  kCameras,   ///< the mean up direction of the cameras: a guess
  kLines,     ///< vertical lines of the map
  kGravity,   ///< an inertial sensor
  kGiven,     ///< the user, who knows how the camera is mounted
  kSurfaces,  ///< horizontal surfaces, if the map itself has only a guess
};
constexpr auto ChoicesOf(VerticalSource) {
  return std::array{Choice{"cameras", VerticalSource::kCameras}, Choice{"lines", VerticalSource::kLines},
                    Choice{"gravity", VerticalSource::kGravity}, Choice{"given", VerticalSource::kGiven},
                    Choice{"surfaces", VerticalSource::kSurfaces}};
}

/// The up direction in the map frame, which has the axes of the first keyframe and is tilted like that camera.
struct Vertical {
  Eigen::Vector3d up_w = -Eigen::Vector3d::UnitY();  ///< unit length
  VerticalSource source = VerticalSource::kCameras;
  /// Sigma of each of its two angles; 0: not known (kCameras, kGiven, kSurfaces: a floor may slope).
  double sigma_rad = 0.0;
  /// Lines that agree, within 3 degrees (kLines), keyframes that measured it (kGravity), or surface elements that agree
  /// (kSurfaces).
  int64_t n = 0;
};

/// Returns the mean of `up_c` of the keyframes in w; `up_c` itself without keyframes, or if they cancel each other.
Eigen::Vector3d MeanUpOfCameras(const Map& map, const Eigen::Vector3d& up_c = -Eigen::Vector3d::UnitY());

/// Returns the common direction of the lines within 45 degrees of `about_w`: corners of buildings, door frames, posts.
/// Each line votes with its precision (endpoint covariances over its length); the direction with most votes is refined
/// by a mean with Tukey's weights, which slanted lines do not bias. Returns nullopt if fewer than 8 lines, or less than
/// a fifth of the votes, agree.
std::optional<Vertical> VerticalFromLines(const Map& map, const Eigen::Vector3d& about_w);

/// Returns the common direction of the normals within 45 degrees of `about_w`: of floors, tables and roads. Returns nullopt
/// if fewer than 200, or less than a fifth of those, agree within 8 degrees.
std::optional<Vertical> VerticalFromNormals(std::span<const Eigen::Vector3d> normals_w,
                                            const Eigen::Vector3d& about_w);

/// Returns the mean of the verticals that an inertial sensor measured from the keyframes. Their errors have common
/// causes (bias, mounting), so its variance is their harmonic mean, not less for more keyframes, and scaled by their
/// scatter if that exceeds the sigmas. Returns nullopt if no keyframe has measured one, or they cancel each other.
std::optional<Vertical> VerticalFromGravity(const Map& map);

/// Returns the vertical by gravity if its sigma is below 1 degree; else the direction of the lines near it, or near the
/// mean up of the cameras; else the vertical by gravity, or that mean.
Vertical VerticalOf(const Map& map);

/// Returns the same, or for three numbers the mean of this direction of the cameras (kGiven). Throws
/// std::invalid_argument, in a sentence without its subject, if there are other numbers than three, or all are zero.
Vertical VerticalOf(const Map& map, const std::vector<double>& up_c);

/// Returns the shortest rotation from w to the levelled frame, in which up is -y (x right, y down, z forward, as in w).
Eigen::Quaterniond LevelRotation(const Eigen::Vector3d& up_w);

}  // namespace plslam
