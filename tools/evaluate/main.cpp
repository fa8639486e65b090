// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/command_line.h"

int main(int argc, char** argv) { return plslam::RunEvaluate(argc, argv); }
