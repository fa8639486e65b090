// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <vector>

#include "core/features/features.h"
#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/geometry/up_direction.h"
#include "core/ids/ids.h"

namespace plslam {
class camera_t;
class intrinsics_t;
class line_feature_t;
class mask_t;
class point_feature_t;
class pose3_t;
class rectified_camera_t;
}  // namespace plslam

namespace plslam::bus {

/// Largest octave of a feature in a message.
inline constexpr int kMaxOctave = 31;

// Conversion of values to messages and back. All content from the wire is checked: non-finite numbers, invalid
// rotations, impossible sizes and unknown names. Invalid content gives nullopt (false), never a guess.

/// Whether all values are finite and above zero.
bool PositiveFinite(std::initializer_list<double> values);

/// The quaternion has w >= 0.
pose3_t ToMessage(const SE3& T_a_b);
/// Unit quaternion (to 1e-6) and finite position. A quaternion that is unit up to rounding keeps all its bits, except
/// for its sign.
std::optional<SE3> FromMessage(const pose3_t& message);

rectified_camera_t ToMessage(const StereoCamera& camera);
/// Focal length and image size of at least one pixel, positive baseline.
std::optional<StereoCamera> FromMessage(const rectified_camera_t& message);

/// Row major.
void ToArray(const Matrix6d& covariance, double (&values)[36]);
/// Finite, with a diagonal that is not negative, symmetric to rounding.
std::optional<Matrix6d> FromArray(const double (&values)[36]);

/// The direction, and its sigma; zeros for nullopt.
void ToArray(const std::optional<UpDirection>& up, double (&up_c)[3], double& sigma_rad);
/// False if the vector is not unit (to 1e-6), or the sigma not positive and finite; zeros give nullopt.
bool FromArray(const double (&up_c)[3], double sigma_rad, std::optional<UpDirection>& up);

/// Least significant byte of the first word first.
void ToBytes(const Descriptor& descriptor, uint8_t (&bytes)[32]);
Descriptor FromBytes(const uint8_t (&bytes)[32]);

/// Header not filled in.
camera_t ToMessage(const RigCalibration& rig);
std::optional<RigCalibration> FromMessage(const camera_t& message);
/// Header and frame number not filled in. Such masks are bounded as those of a rig.
mask_t ToMessage(const FrameMask& mask);
std::optional<FrameMask> FromMessage(const mask_t& message);
/// The encoded rig without its header, which differs from message to message: equal for equal rigs.
std::vector<uint8_t> RigBytes(camera_t message);

/// `landmark_id` of vo_process and `map_id` of the map; -1: none. They are not part of the decoded feature.
point_feature_t ToMessage(const StereoPoint& point, TrackId landmark_id, LandmarkId map_id);
std::optional<StereoPoint> FromMessage(const point_feature_t& message);
line_feature_t ToMessage(const StereoLine& line, TrackId landmark_id, LandmarkId map_id);
std::optional<StereoLine> FromMessage(const line_feature_t& message);

}  // namespace plslam::bus
