// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <string>

namespace plslam::test {

/// Returns a Python that has numpy: Debian's, if the first one in the path has none. Empty if there is none.
inline std::string PythonWithNumpy() {
  for (const std::string program : {"python3", "/usr/bin/python3"}) {
    if (std::system((program + " -c 'import numpy' >/dev/null 2>&1").c_str()) == 0) return program;  // NOLINT
  }
  return "";
}

}  // namespace plslam::test
