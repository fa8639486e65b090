#include "tools/evaluate/run_summary.h"

#include <fstream>
#include <stdexcept>

namespace plslam {

nlohmann::json ReadRunSummary(const std::string& folder) {
  const std::string path = folder + "/summary.json";
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + ": cannot be opened; is this the folder of a run?");
  auto summary = nlohmann::json::parse(file, nullptr, false);
  if (summary.is_discarded() || !summary.is_object()) throw std::runtime_error(path + ": is not readable as JSON");
  return summary;
}

}  // namespace plslam
