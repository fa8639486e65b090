#pragma once

#include <optional>

#include "plslam/pose_t.hpp"
#include "plslam/tracks_t.hpp"
#include "viewer_headless/overlay.h"
#include "viewer_headless/recorder.h"

namespace plslam {

/// Messages as the plain values of this folder; nullopt where poses or covariances are none.
std::optional<FramePose> ToFramePose(const pose_t& message);
OverlayFeatures ToOverlayFeatures(const tracks_t& message);

}  // namespace plslam
