#include "core/bus/process.h"
#include "vo_process/vo_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::VoSpec()); }
