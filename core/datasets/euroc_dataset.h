// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// EuRoC in the ASL layout (Burri et al., IJRR 2016): `mav0/cam0`, `mav0/cam1`, each with `data.csv`, `data/` and
/// `sensor.yaml` (radial-tangential or equidistant, handed on as it is); `folder` is the one that holds mav0, or mav0.
/// Rows of the two cameras are paired by time (within half a millisecond); rows without partner are skipped and counted
/// in Notes. True poses of the body from `state_groundtruth_estimate0/data.csv` (8 or 17 columns) or else, in TUM-VI
/// (Schubert et al., IROS 2018), from `mocap0/data.csv` (8), interpolated and moved to the left camera; none outside
/// their span or in gaps longer than 0.15 s. Body: the IMU. Without both `sensor.yaml`, `dso/camchain.yaml` beside mav0
/// is used, and without that of `imu0`, `dso/imu_config.yaml`, as TUM-VI is published.
std::unique_ptr<Dataset> OpenEurocDataset(const std::string& folder);

/// Returns whether there is a cam0/data.csv in the folder or in its mav0.
bool LooksLikeEuroc(const std::string& folder);

}  // namespace plslam
