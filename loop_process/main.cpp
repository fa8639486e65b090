#include "core/bus/process.h"
#include "loop_process/loop_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::LoopSpec()); }
