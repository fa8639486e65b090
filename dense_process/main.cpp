// SPDX-License-Identifier: BSD-3-Clause
#include "core/process/process.h"
#include "dense_process/node/dense_node.h"

int main(int argc, char** argv) { return plslam::bus::RunProcess(argc, argv, plslam::dense::DenseSpec()); }
