// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace plslam {

/// Returns the sentence for an error of the command line, without the name of the program. A command or option that does
/// not exist comes before all else, because other errors often follow from it; the nearest one is named if only a few
/// letters differ.
std::string CommandLineError(const CLI::App& app, const CLI::ParseError& error, int argc, char** argv);

}  // namespace plslam
