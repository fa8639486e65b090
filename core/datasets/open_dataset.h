// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/datasets/dataset.h"
#include "core/datasets/dataset_kinds.h"

namespace plslam {

/// Returns the dataset with other pairs: the left image of each frame with the right image of `offset` frames later
/// (earlier if it is negative), for recordings that were paired wrongly. Times, truth and the camera are those of the
/// left images; frames without a partner, at the beginning or the end, are left out. Throws DatasetError if no pair is
/// left, or if right images are depths.
std::unique_ptr<Dataset> ShiftRightImages(std::unique_ptr<Dataset> dataset, int offset);

/// Opens a dataset of one of these kinds: a folder, a file ("run.mcap?left=/cam0/image_raw"), or a built-in world
/// ("synthetic:room?seed=3"). `kind` is the name of one, or empty to detect it. Throws DatasetError.
std::unique_ptr<Dataset> OpenDataset(const std::string& location, const std::string& kind);

/// Prints the notes of the dataset on standard error.
void PrintNotes(const Dataset& dataset);
/// Opens a dataset, and prints its notes.
std::unique_ptr<Dataset> OpenDatasetAndWarn(const std::string& location, const std::string& kind);

/// Returns the location of a recording that plays these two image topics, a left and a right one; unchanged if `topics`
/// is empty. Throws DatasetError if there are topics, and the dataset is no recording of ROS.
std::string WithTopics(const std::string& location, const std::string& kind, const std::vector<std::string>& topics);

}  // namespace plslam
