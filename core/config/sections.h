// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace plslam {

/// First-level keys of a configuration file, one for each process or shared part.
inline constexpr std::string_view kConfigSections[] = {"bus", "player", "vo", "mapping", "loop", "viewer"};

}  // namespace plslam
