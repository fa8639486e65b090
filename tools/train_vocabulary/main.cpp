// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/command_line.h"

int main(int argc, char** argv) { return plslam::train_vocabulary::RunTrainVocabulary(argc, argv); }
