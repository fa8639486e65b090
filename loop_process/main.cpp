// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"
#include "loop_process/node/loop_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::loop::LoopSpec()); }
