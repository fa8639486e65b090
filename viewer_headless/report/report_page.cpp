#include "viewer_headless/report/report_page.h"

#include <fstream>
#include <iterator>
#include <stdexcept>

#include "core/io/files/shared_file.h"

namespace plslam {
namespace {

constexpr std::string_view kPlace = "\"PLSLAM_RUN_DATA\"";

}  // namespace

std::optional<std::string> ReadReportTemplate() {
  std::ifstream stream(SharedFile("report_template.html"), std::ios::binary);
  if (!stream) return std::nullopt;
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

std::string FillTemplate(const std::string& page, std::string_view json) {
  const size_t at = page.find(kPlace);
  if (at == std::string::npos) throw std::runtime_error("report_template.html has no place for the data of a run");
  std::string filled;
  filled.reserve(page.size() + json.size());
  filled.append(page, 0, at).append(json).append(page, at + kPlace.size());
  return filled;
}

}  // namespace plslam
