// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"
#include "tools/bridge/node/bridge_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::bridge::BridgeSpec()); }
