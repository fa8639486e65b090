// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

namespace plslam {

/// The white level of a sequence of `n_frames` pairs (`WhiteLevel` in core/io/images/image_file.h), one for all frames
/// and both cameras: that of the largest value in the first pair, the last one, and those at each quarter between.
/// `largest` gives the largest value of the images of a pair, 0 for images of 8 bits, after which no other is looked
/// at; a pair for which it throws is passed over. Where it is less than that of 16 bits, `notes` says so.
int WhiteLevelOf(int n_frames, const std::function<int(int frame)>& largest, std::vector<std::string>* notes);

}  // namespace plslam
