// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "tests/support/text_file.h"

namespace plslam::test {

/// A wall 2 m away, along which the camera moves by 2 cm a frame, as a folder of colour and depth.
std::string WallOfAnRgbdCamera(const plslam::ScratchFolder& folder, int n_frames);

}  // namespace plslam::test
