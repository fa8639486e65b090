// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace plslam::launcher {

/// Converts YAML; unquoted true, false and numbers become such values, all others text. Invalid YAML (for example
/// truncated) becomes a text.
nlohmann::json YamlToJson(const std::string& yaml);

}  // namespace plslam::launcher
