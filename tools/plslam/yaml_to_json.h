// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace plslam::launcher {

/// The same content; unquoted true, false and numbers become such, everything else text. YAML that cannot be read
/// (one that was cut, say) becomes a text as it is.
nlohmann::json YamlToJson(const std::string& yaml);

}  // namespace plslam::launcher
