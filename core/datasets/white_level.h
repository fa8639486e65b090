// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/io/files/notes.h"

namespace plslam {

/// Returns the white level of a sequence of `n_frames` pairs (`WhiteLevel` in core/io/images/image_file.h), one for all
/// frames and both cameras: that of the largest value in the first pair, the last one, and those at each quarter
/// between. `largest` returns the largest value of the images of a pair, 0 for 8-bit images, after which no other pair
/// is read; a pair for which it throws is skipped. If the level is less than 16 bits, `notes` says so.
int WhiteLevelOf(int n_frames, const std::function<int(int frame)>& largest, Notes* notes);

}  // namespace plslam
