// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

namespace CLI {
class App;
}

namespace plslam {

/// The end of a tool's main: reads the command line and calls `work`. Returns the exit code: that of `work`; 0 after
/// --help and the like; 1 for an error of the command line or an exception of `work`, which is printed on standard
/// error under the name of the app.
int RunCommandLine(CLI::App& app, int argc, char** argv, const std::function<int()>& work);

}  // namespace plslam
