// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/stereo_camera.h"
#include "vo_process/stereo/stereo_matcher.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"

namespace plslam::vo {

/// Features from which landmarks can be created, lines counted twice.
int CreatableLandmarks(const StereoFeatures& features);

/// Median depth of the features of the world; 0 if there are none.
double MedianDepth(const TrackedFrame& frame, const StereoCamera& camera);

/// Share of the landmarks matched in the frame, lines counted twice, that so many keyframes of the map observe.
double KnownShare(const TrackedFrame& frame, int observations);

}  // namespace plslam::vo
