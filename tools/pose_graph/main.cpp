// SPDX-License-Identifier: BSD-3-Clause
#include "tools/pose_graph/command_line.h"

int main(int argc, char** argv) { return plslam::pose_graph::RunPoseGraph(argc, argv); }
