// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "core/run/recorder.h"
#include "plslam/bodies_t.hpp"
#include "plslam/pose_t.hpp"

namespace plslam {

/// Conversion of messages to the values of a Recorder; nullopt if poses or covariances are invalid.
std::optional<FramePose> ToFramePose(const pose_t& message);
std::optional<BodiesOfFrame> ToBodiesOfFrame(const bodies_t& message);

}  // namespace plslam
