// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"
#include "mapping_process/node/mapping_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::mapping::MappingSpec()); }
