// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace plslam {

/// The object in `FOLDER/summary.json` of a run. Throws std::runtime_error, which names the file, where there is
/// none.
nlohmann::json ReadRunSummary(const std::string& folder);

}  // namespace plslam
