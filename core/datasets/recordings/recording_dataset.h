// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// The stereo images of a recording of ROS 2 (MCAP) or ROS 1 (bag): "FILE", or with topics and calibration given,
/// "FILE?left=/a/image_raw&right=/b/image_raw&truth=/pose&camera=camera.yaml" (docs/datasets.md).
///
/// Without topics they are found by looking: two of one name but for left and right, cam0 and cam1, infra1 and
/// infra2, image_0 and image_1. The rig is that of their camera_info. Times are header stamps (message_times.h); those of
/// logging only where the stamps of an image topic are zero or constant, or left and right ones are of two clocks, as
/// `Notes` tells then. Images are read on demand through the index, of which memory holds 40 bytes for each message.
///
/// A file without index, or cut off, is played as far as it is whole (recording.h); `Notes` tells.
///
/// Throws DatasetError naming the file where it is another file or damaged, where topics or calibration are missing
/// (then with a list of the topics), or where a lens has no counterpart here.
std::unique_ptr<Dataset> OpenMcapDataset(const std::string& location);
std::unique_ptr<Dataset> OpenBagDataset(const std::string& location);

/// There is such a file, and it begins as MCAP files do, or as bags of ROS 1 of any version; or it is called FILE.mcap,
/// or FILE.bag.
bool LooksLikeMcap(const std::string& location);
bool LooksLikeBag(const std::string& location);

/// The location without the options that are given behind "?", if any: the file that is read.
std::string FileOfLocation(const std::string& location);

}  // namespace plslam
