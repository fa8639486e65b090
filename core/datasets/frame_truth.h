// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/datasets/image_list.h"
#include "core/io/trajectories/trajectory.h"

namespace plslam {

/// True pose of each entry of `list` by InterpolatePose, as the file at `path` has them. Where fewer than half of the
/// frames get one (clocks of two kinds, truth of another part of the sequence) `list` gets a note with both spans of
/// time.
std::vector<std::optional<SE3>> FrameTruth(const std::string& path, TrajectoryFormat format, ImageList* list);

}  // namespace plslam
