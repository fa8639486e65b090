// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace plslam {

/// `NAME:LINE: ...` for YAML that cannot be parsed: `line` (from 0; below 0: unknown) and `what` as the parser says
/// them, with the text of the line. A tab before a key, of which the parser complains at another line in other words,
/// is found here.
std::string YamlComplaint(const std::string& name, std::string_view text, int line, const std::string& what);

}  // namespace plslam
