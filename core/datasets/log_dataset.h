// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam::bus {

/// Opens the stereo stream of an LCM log, made by the stock lcm-logger or by `plslam record`: rig, frames of the
/// lockstep or the live channel, ground truth. Channels may have a prefix, messages a MAC (which is not checked here),
/// strips may be repeated or out of order. If there are several publishers (with that `prefix`, if it is given), the
/// one with the most strips is used, joined with those of its prefix that sent before and after it with the same rig: a
/// publisher was restarted. `Notes` gives the frames of others.
///
/// Frames that lack strips are skipped, and as few frames as possible if times do not increase (a camera's clock was
/// set back); `Notes` gives the numbers.
///
/// Throws DatasetError naming the file if it cannot be read or has no rig or no complete frames. `Read` of a frame with
/// malformed strips throws DatasetError naming file and frame.
std::unique_ptr<Dataset> OpenLogDataset(const std::string& path, const std::optional<std::string>& prefix);
inline std::unique_ptr<Dataset> OpenLogDataset(const std::string& path) { return OpenLogDataset(path, std::nullopt); }

}  // namespace plslam::bus
