// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "plslam/status_t.hpp"
#include "plslam/tracks_t.hpp"
#include "viewer_headless/overlay.h"
#include "viewer_headless/report/process_log.h"

namespace plslam::viewer {

/// Conversion of messages to the plain values of this folder.
OverlayFeatures ToOverlayFeatures(const tracks_t& message);
/// `t_s` is the time of reception by the listener's clock, when `frame_id` was the newest frame.
ProcessSample ToProcessSample(const status_t& message, double t_s, FrameId frame_id);

}  // namespace plslam::viewer
