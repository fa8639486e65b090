// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam {

/// `evaluate figures RUN`: draws what the folder of a run gives, as PNG and SVG. Returns the exit code: 0, or 1 after
/// one sentence on stderr. `argv[0]` is the word `figures`.
int RunEvaluateFigures(int argc, char** argv);

}  // namespace plslam
