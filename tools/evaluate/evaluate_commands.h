// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam::evaluate {

/// The program `evaluate`: reads the files of the command line, prints the table, writes JSON and plot; `compare`,
/// `figures` and `places` are handed on to the commands below. These take their own word as `argv[0]`. All return the
/// exit code: 0, or 1 after one sentence on stderr (`RunEvaluate` also if no pose can be associated).
int RunEvaluate(int argc, char** argv);

/// `evaluate compare RUN...`: runs side by side.
int RunEvaluateCompare(int argc, char** argv);

/// `evaluate figures RUN`: draws the figures of a run's folder, as SVG, PDF and PNG.
int RunEvaluateFigures(int argc, char** argv);

/// `evaluate places DATASET...`: reads sequences with true poses, prints how well places are recognised by points,
/// lines and both, writes pictures and JSON.
int RunEvaluatePlaces(int argc, char** argv);

}  // namespace plslam::evaluate
