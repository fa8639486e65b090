// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/map/landmark_types.h"
#include "core/map/landmarks.h"

namespace plslam::mapping {

/// Adds an observation to a landmark. Returns false if the keyframe already observes the landmark, or the feature
/// another one. Selects the landmark's descriptor again (PL-SLAM §V.A: the most representative one).
template <class Type>
bool AddObservation(LandmarkId landmark_id, const Observation& observation, const KeyframeFeatures& features,
                    Map& map);

/// Removes an observation, and the landmark with its last one.
template <class Type>
void DropObservation(LandmarkId landmark_id, KeyframeId keyframe_id, const KeyframeFeatures& features, Map& map);

/// Fuses two landmarks under the smaller id. Returns false and does nothing if one keyframe observes both.
template <class Type>
bool Fuse(LandmarkId a, LandmarkId b, const KeyframeFeatures& features, Map& map);

/// Returns the sum of squared residuals of a feature in both images, in variances, at most `kMostObservationError`,
/// which is also the value for a point behind the camera. Never NaN.
double ObservationError(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w,
                        const StereoCamera& camera);
/// Sibling: uses the distances of the two endpoints from the infinite observed line.
double ObservationError(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera);

inline constexpr double kMostObservationError = 25.0;

/// Whether the landmark projects within a few dozen pixels of the feature (for a line: its middle, across the segment):
/// the possible error of a pose from the tracker.
bool IsNear(const MapPoint& point, const StereoPoint& seen, const SE3& T_kf_w, const StereoCamera& camera);
bool IsNear(const MapLine& line, const StereoLine& seen, const SE3& T_kf_w, const StereoCamera& camera);

/// Whether the whole landmark is behind the camera, so that the keyframe cannot observe it.
bool IsBehind(const MapPoint& point, const SE3& T_kf_w, const StereoCamera& camera);
bool IsBehind(const MapLine& line, const SE3& T_kf_w, const StereoCamera& camera);

}  // namespace plslam::mapping
