// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam {

/// `evaluate compare RUN...`: runs side by side. Returns the exit code: 0, or 1 after one sentence on stderr.
/// `argv[0]` is the word `compare`.
int RunEvaluateCompare(int argc, char** argv);

}  // namespace plslam
