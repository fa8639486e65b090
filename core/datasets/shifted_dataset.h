// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "core/datasets/dataset.h"

namespace plslam {

/// The dataset with other pairs: the left image of each frame with the right image of `offset` frames later (earlier
/// where it is negative), for recordings that were paired wrongly. Times, truth and the camera are those of the left
/// images; frames without a partner, at the beginning or the end, are left out. Throws DatasetError where no pair is
/// left, or where right images are depths.
std::unique_ptr<Dataset> ShiftRightImages(std::unique_ptr<Dataset> dataset, int offset);

}  // namespace plslam
