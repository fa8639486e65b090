// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "camera/rig_file.h"

namespace plslam::camera {

/// The names of the two appsinks that images are taken from.
inline constexpr const char* kLeftSink = "left";
inline constexpr const char* kRightSink = "right";

/// Returns the pipeline for gst_parse_launch: a template of the type of source, with grey images of the rig's size, or
/// the text in the file if it has one.
std::string PipelineText(const LiveRig& live);

}  // namespace plslam::camera
