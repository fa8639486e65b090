// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam {

/// TUM RGB-D (Sturm et al., IROS 2012): `rgb.txt`, `depth.txt`, optional `groundtruth.txt`. Pairs are read from
/// `associations.txt` (time and file of the colour image, time and file of the depth map) or, without it, are the
/// nearest in time, at most 20 ms apart, each image used once. Camera: `camera.yaml` of the folder, else TUM's own
/// calibration when the folder's name holds freiburg1, freiburg2, freiburg3 (or fr1, fr2, fr3). Depth is 16-bit, 5000
/// units a metre unless the camera file differs. Times are those of the colour images.
std::unique_ptr<Dataset> OpenTumDataset(const std::string& folder);

/// Returns whether there is a depth.txt beside rgb.txt, or an associations.txt.
bool LooksLikeTum(const std::string& folder);

}  // namespace plslam
