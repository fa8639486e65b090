// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// The dataset with other pairs: the left image of each frame with the right image of `offset` frames later (earlier
/// where it is negative), for recordings that were paired wrongly. Times, truth and the camera are those of the left
/// images; frames without a partner, at the beginning or the end, are left out. Throws DatasetError where no pair is
/// left, or where right images are depths.
std::unique_ptr<Dataset> ShiftRightImages(std::unique_ptr<Dataset> dataset, int offset);

/// Opens a folder (KITTI odometry, EuRoC ASL, TUM RGB-D, VSLAM-LAB, left/right images with a camera file), an LCM log, a
/// recording of ROS ("run.mcap?left=/cam0/image_raw", "run.bag"), or a built-in world ("synthetic:room?seed=3"). `kind` names
/// the format ("kitti", "euroc", "tum", "vslamlab", "images", "log", "mcap", "bag", "synthetic"), or is empty to find it by looking.
/// Throws DatasetError.
std::unique_ptr<Dataset> OpenDataset(const std::string& location, const std::string& kind);

}  // namespace plslam
