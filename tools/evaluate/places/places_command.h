// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam {

/// `evaluate places`: reads sequences with true poses, prints how well places are recognised by points, lines and
/// both, writes pictures and JSON. `argv[0]` is "places". Returns the exit code: 0, or 1 after one sentence on
/// stderr.
int RunEvaluatePlaces(int argc, char** argv);

}  // namespace plslam
