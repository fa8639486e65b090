// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/run_summary.h"

#include <fstream>
#include <stdexcept>

#include "core/errors/error_text.h"

namespace plslam {

nlohmann::json ReadRunSummary(const std::string& folder) {
  const std::string path = folder + "/summary.json";
  const std::string why = WhyUnreadable(path);
  if (!why.empty()) throw std::runtime_error(path + ": " + why + "; is " + folder + " the folder of a run?");
  std::ifstream file(path);
  auto summary = nlohmann::json::parse(file, nullptr, false);
  if (summary.is_discarded() || !summary.is_object()) throw std::runtime_error(path + ": is not readable as JSON");
  return summary;
}

}  // namespace plslam
