// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam::pose_graph {

/// The program `pose_graph`: 0 when a minimum was found, 1 with one sentence on the standard error output otherwise.
int RunPoseGraph(int argc, char** argv);

}  // namespace plslam::pose_graph
