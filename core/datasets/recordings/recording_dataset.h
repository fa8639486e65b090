// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// The stereo images of a recording of ROS 2 (MCAP, .db3 or a folder of either) or ROS 1 (bag): "FILE", or with topics and calibration given,
/// "FILE?left=/a/image_raw&right=/b/image_raw&truth=/pose&imu=/imu&camera=camera.yaml" (docs/datasets.md).
///
/// Without topics they are detected: two of one name except for left and right, cam0 and cam1, infra1 and infra2,
/// image_0 and image_1. The rig is that of their camera_info. Times are header stamps (message_times.h); logging times
/// only if the stamps of an image topic are zero or constant, or left and right ones are of different clocks, as
/// `Notes` then reports. Images are read on demand through the index, of which memory holds 40 bytes for each message.
///
/// The inertial sensor is that of sensor_msgs/Imu; all its samples are read at opening. Its calibration is `imu` of the
/// camera file, imu.yaml beside the recording, and the transforms on /tf_static.
///
/// Where a clock was set back in between, its parts are played alone ("FILE?part=2").
///
/// A file without index, or truncated, is played as far as it is complete (recording.h); `Notes` reports this.
///
/// Throws DatasetError naming the file if it has another format or is damaged, if topics or calibration are missing
/// (then with a list of the topics), or if a lens has no equivalent model here.
std::unique_ptr<Dataset> OpenMcapDataset(const std::string& location);
std::unique_ptr<Dataset> OpenBagDataset(const std::string& location);
std::unique_ptr<Dataset> OpenRos2BagDataset(const std::string& location);

/// There is such a file, and it begins as MCAP files do, or as bags of ROS 1 of any version; or it is called FILE.mcap,
/// or FILE.bag.
bool LooksLikeMcap(const std::string& location);
bool LooksLikeBag(const std::string& location);
/// There is such a .db3 file, or a folder of the files of a bag (ros2_bag.h).
bool LooksLikeRos2Bag(const std::string& location);

/// Returns the file of a location, without the options after "?", if any.
std::string FileOfLocation(const std::string& location);

}  // namespace plslam
