// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "core/datasets/dataset.h"

namespace plslam::test {

/// A frame of a made-up sequence: one of a dataset's, or a covered lens.
struct ChosenFrame {
  int index = 0;
  bool covered = false;
};

/// Writes frames of a rectified dataset, in any order, as a folder of images with camera, times (20 Hz) and true
/// poses.
void WriteImageFolder(const Dataset& dataset, const std::vector<ChosenFrame>& frames,
                      const std::filesystem::path& folder);

}  // namespace plslam::test
