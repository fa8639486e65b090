// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// A sequence as VSLAM-LAB (Fontan et al., 2025) lays all its datasets out: `rgb.csv` with time and file of `rgb_0` and
/// `rgb_1`, or of `rgb_0` and `depth_0`, in columns found by their names; `calibration.yaml` with a list of cameras of
/// these names (pinhole with radtan4, radtan5, radtan8, equid4 or no distortion; `T_BS`, or `T_SC` as it was called,
/// takes points of the camera to the body); and, where it has poses, `groundtruth.csv` of the body, which is moved to
/// the left camera.
std::unique_ptr<Dataset> OpenVslamLabDataset(const std::string& folder);

/// There are rgb.csv and calibration.yaml.
bool LooksLikeVslamLab(const std::string& folder);

}  // namespace plslam
