// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "tests/support/text_file.h"

namespace plslam::test {

struct ShellResult {
  int exit_code = -1;
  std::string out;
  std::string error;
};

/// Runs a line of shell with its outputs in files of the folder.
inline ShellResult Shell(const ScratchFolder& folder, const std::string& line) {
  const std::string command = "(" + line + ") >" + folder.Path("out") + " 2>" + folder.Path("error");
  const int status = std::system(command.c_str());  // NOLINT: the test runs other programs
  return {WEXITSTATUS(status), ReadText(folder.Path("out")), ReadText(folder.Path("error"))};
}

inline bool HasProgram(const std::string& name) {
  return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;  // NOLINT
}

}  // namespace plslam::test

/// Leaves the test, visibly skipped, where the program is not installed.
#define PLSLAM_REQUIRE_PROGRAM(name) \
  if (!plslam::test::HasProgram(name)) GTEST_SKIP() << "the program '" << (name) << "' is not installed"
