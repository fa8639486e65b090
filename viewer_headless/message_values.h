#pragma once

#include "core/geometry/calibration.h"
#include "plslam/camera_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/tracks_t.hpp"
#include "viewer_headless/overlay.h"
#include "viewer_headless/recorder.h"

namespace plslam {

/// Messages as the plain values of this folder. Nothing is checked here: the takers of the values do that.
SE3 ToSe3(const pose3_t& message);
RigCalibration ToRig(const camera_t& message);
FramePose ToFramePose(const pose_t& message);
OverlayFeatures ToOverlayFeatures(const tracks_t& message);

}  // namespace plslam
