// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/datasets/dataset.h"

namespace plslam {

/// The dataset with other pairs: the left image of each frame with the right image of `offset` frames later (earlier
/// where it is negative), for recordings that were paired wrongly. Times, truth and the camera are those of the left
/// images; frames without a partner, at the beginning or the end, are left out. Throws DatasetError where no pair is
/// left, or where right images are depths.
std::unique_ptr<Dataset> ShiftRightImages(std::unique_ptr<Dataset> dataset, int offset);

/// A format of datasets.
struct DatasetKind {
  std::string name;  ///< "kitti"
  std::string sign;  ///< by which it is found: "calib.txt with image_0 or image_2"
  std::string what;  ///< "KITTI odometry"
  bool is_folder = true;
};

/// All there are, in the order in which they are looked for.
const std::vector<DatasetKind>& DatasetKinds();
/// What can be played, and the names of the kinds, as help texts have them.
std::string DatasetHelp();
std::string DatasetKindHelp();

/// Opens a dataset of one of these kinds: a folder, a file ("run.mcap?left=/cam0/image_raw"), or a built-in world
/// ("synthetic:room?seed=3"). `kind` is the name of one, or empty to find it by looking. Throws DatasetError.
std::unique_ptr<Dataset> OpenDataset(const std::string& location, const std::string& kind);

/// The location of a recording of which these two image topics are played: empty, or a left and a right one. Throws
/// DatasetError where there are topics, and the dataset is no recording of ROS.
std::string WithTopics(const std::string& location, const std::string& kind, const std::vector<std::string>& topics);

}  // namespace plslam
