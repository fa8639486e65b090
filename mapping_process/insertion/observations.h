// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "core/map/landmarks.h"

namespace plslam::mapping {

/// Names the landmark as the one that the feature of `observation` shows, unless its keyframe sees the landmark
/// already or the feature shows another; then false. Its descriptor is chosen anew (PL-SLAM §V.A: the most
/// representative one).
template <class Type>
bool AddObservation(int64_t landmark_id, const Observation& observation, const KeyframeFeatures& features, Map& map);

/// Takes an observation away; the landmark goes with its last one.
template <class Type>
void DropObservation(int64_t landmark_id, int64_t keyframe_id, const KeyframeFeatures& features, Map& map);

/// Makes one landmark of two, under the smaller id. False, and nothing done, where a keyframe sees them apart.
template <class Type>
bool Fuse(int64_t a, int64_t b, const KeyframeFeatures& features, Map& map);

/// How badly a feature agrees with the point it shows: squared distances in both images in standard deviations, at
/// most `kMostObservationError`, which is also what a point behind the camera gives. Never a NaN.
double ObservationError(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w,
                        const StereoCamera& camera);
/// Sibling: distances of the two ends from the infinite observed line.
double ObservationError(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera);

inline constexpr double kMostObservationError = 25.0;

/// Whether the landmark appears within a few dozen pixels of the feature (of a line: of its middle, across): as far
/// as a pose by the tracker may be off.
bool IsNear(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w, const StereoCamera& camera);
bool IsNear(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera);

/// Nothing of the landmark is in front of the camera: the keyframe cannot have seen it.
bool IsBehind(const MapPoint& point, const SE3& T_kf_w, const StereoCamera& camera);
bool IsBehind(const MapLine& line, const SE3& T_kf_w, const StereoCamera& camera);

}  // namespace plslam::mapping
