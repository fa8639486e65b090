// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/map/map.h"
#include "core/run/recorder.h"
#include "core/run/run.h"

namespace plslam {

/// Returns the poses and covariances of a recording; the other members are nullopt. Frames with state lost have no pose
/// of their own and appear only in the table. A frame whose time is not after that of the previous one is left out too.
/// `live` has the same frames as `trajectory`, `keyframes` are those of the map or, without a map, frames that became
/// keyframes. Motion covariances are of neighbours that are neighbours in the recording too.
///
/// `q_l_c` rotates directions of the rectified left camera c into l. A `map` without keyframes counts as no map. Only of
/// one part, if the map has unconnected ones (`RunParts`): the main one is 0.
Run RunOf(const Recorder& recorder, const Map& map, const Eigen::Quaterniond& q_l_c, size_t part = 0);

/// Returns the table of `WritePosesCsv`.
FrameTable FrameTableOf(const Recorder& recorder);

/// Takes the next part of a text.
using AppendText = std::function<void(std::string_view)>;

/// One row for each frame, lost ones included: time, state, counts, stage times.
void WritePosesCsv(const Recorder& recorder, const AppendText& append);

/// One row for each moving body in each frame: T_w_body in the map as it is at the end; the body's frame as in body_t.
void WriteBodiesCsv(const Recorder& recorder, const Map& map, const AppendText& append);

/// Makes the folder and proves that files can be written there. Throws std::runtime_error.
void PrepareOutputFolder(const std::string& folder);

/// Throws std::runtime_error with one sentence if the folder has results of a run (`kResultFiles`).
void CheckHasNoResults(const std::string& folder);
/// Removes the results of a run from its folder, with its pictures of features.
void RemoveResults(const std::string& folder);

/// Writes trajectories, covariances, tables and `map.ply`, each whole or not at all, frame by frame: memory does not grow
/// with the length of the run. Tries each, and returns a sentence for each that could not be written.
std::vector<std::string> WriteOutputs(const std::string& folder, const Recorder& recorder, const Map& map,
                                      const Eigen::Quaterniond& q_l_c);

}  // namespace plslam
