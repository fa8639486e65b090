// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "tests/unit/datasets/tiny_recording.h"

namespace plslam::test {

/// A tiny valid bag of ROS 1, with the content of `MakeMcapFile`.
void MakeBagFile(const std::filesystem::path& path, const RecordingOptions& options = {});

}  // namespace plslam::test
