// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace plslam::robot {

/// Whether a topic has CompressedImage instead of Image: it ends with "/compressed" or "/compressedDepth".
bool IsCompressedTopic(std::string_view topic);

/// Returns the CameraInfo topic of an image topic, as drivers of ROS name it: "/a/left/image_raw" has
/// "/a/left/camera_info", and "/left" has "/left/camera_info".
std::string InfoTopicOf(std::string_view image_topic);

}  // namespace plslam::robot
