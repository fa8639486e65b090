#include "core/bus/process.h"
#include "mapping_process/mapping_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::MappingSpec()); }
