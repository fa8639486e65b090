#include "tools/pose_graph/command_line.h"

int main(int argc, char** argv) { return plslam::RunPoseGraph(argc, argv); }
