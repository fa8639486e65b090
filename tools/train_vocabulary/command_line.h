// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam::train_vocabulary {

/// The program `train_vocabulary`: reads images, trains, writes the vocabulary and prints its properties. Returns the
/// exit code: 0, or 1 after one sentence on stderr.
int RunTrainVocabulary(int argc, char** argv);

}  // namespace plslam::train_vocabulary
