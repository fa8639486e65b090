// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam {

/// The program `evaluate`: reads the files of the command line, prints the table, writes JSON and plot; `compare`,
/// `figures` and `places` are handed on to the folders of these names. Returns the exit code: 0, or 1 after one
/// sentence on stderr (also where no pose has a counterpart).
int RunEvaluate(int argc, char** argv);

}  // namespace plslam
