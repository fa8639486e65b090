// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// KITTI odometry (Geiger et al., CVPR 2012; development kit of the odometry benchmark): `calib.txt` with P0/P1 and
/// `image_0`, `image_1`, or in colour P2/P3 and `image_2`, `image_3`; `times.txt`; images NNNNNN.png. True poses of
/// the grey left camera in `poses.txt`, or in `../../poses/NN.txt` of the official layout `sequences/NN`. Body: the
/// grey left camera.
std::unique_ptr<Dataset> OpenKittiDataset(const std::string& folder);

/// There is a calib.txt beside image_0 or image_2.
bool LooksLikeKitti(const std::string& folder);

}  // namespace plslam
