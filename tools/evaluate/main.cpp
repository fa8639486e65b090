// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/evaluate_commands.h"

int main(int argc, char** argv) { return plslam::evaluate::RunEvaluate(argc, argv); }
