// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// A sequence in the layout of VSLAM-LAB (Fontan et al., 2025): `rgb.csv` with time and file of `rgb_0` and `rgb_1`, or
/// of `rgb_0` and `depth_0`, in columns found by their names; `calibration.yaml` with a list of cameras of these names
/// (pinhole with radtan4, radtan5, radtan8, equid4 or no distortion; `T_BS`, formerly `T_SC`, takes points of the
/// camera to the body); and, if it has poses, `groundtruth.csv` of the body, which is moved to the left camera.
std::unique_ptr<Dataset> OpenVslamLabDataset(const std::string& folder);

/// Returns whether there are rgb.csv and calibration.yaml.
bool LooksLikeVslamLab(const std::string& folder);

}  // namespace plslam
