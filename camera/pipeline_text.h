// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "camera/rig_file.h"

namespace plslam::camera {

/// The names of the two appsinks that images are taken from.
inline constexpr const char* kLeftSink = "left";
inline constexpr const char* kRightSink = "right";

/// What GStreamer is asked for, as gst_parse_launch takes it: a template of the type of source, with images of the
/// rig's size in grey; the text of the file where it gives one.
std::string PipelineText(const LiveRig& live);

}  // namespace plslam::camera
