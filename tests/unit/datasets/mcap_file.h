// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "tests/unit/datasets/tiny_recording.h"

namespace plslam::test {

/// A tiny valid recording of ROS 2 in MCAP: three frames of `TinyPixel`, 100 ms apart, a chunk each, camera_info, and
/// the pose (i, 0, 0) of frame i on /ground_truth.
void MakeMcapFile(const std::filesystem::path& path, const RecordingOptions& options = {});

}  // namespace plslam::test
