// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace plslam {

/// Makes a write beyond the limit of a file's size (`ulimit -f`) an error, as on a full disk; by default a signal ends
/// the process.
void IgnoreFileSizeSignal();

/// Prints a line on standard error. If that is a file on a full disk, the line is lost without an exception; fmt::print
/// would throw.
void PrintError(const std::string& line);

/// Writes the rest of standard output at the end of a program. Returns `exit_code`; after a failed write (a full disk)
/// prints one sentence that begins with the name of the program, and returns 1. A closed pipe or terminal is no failure.
int FlushOutput(const std::string& program, int exit_code);

}  // namespace plslam
