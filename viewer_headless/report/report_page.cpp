// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/report_page.h"

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "core/files/shared_file.h"

namespace plslam::viewer {
namespace {

constexpr std::string_view kDataPlace = "\"PLSLAM_RUN_DATA\"";
constexpr std::string_view kOthersPlace = "\"PLSLAM_OTHER_RUNS\"";
constexpr std::string_view kDataBegin = "<script id=\"run-data\" type=\"application/json\">";
constexpr std::string_view kRefinementBegin = "<script id=\"run-refinement\" type=\"application/json\">";
constexpr std::string_view kWarningsPlace = "\"PLSLAM_RUN_WARNINGS\"";

PageAroundData Around(std::string_view page, std::string_view place, const char* lacks) {
  const size_t at = page.find(place);
  if (at == std::string_view::npos) throw std::runtime_error(lacks);
  return {page.substr(0, at), page.substr(at + place.size())};
}

std::string Fill(const PageAroundData& page, std::string_view json) {
  std::string filled;
  filled.reserve(page.before.size() + json.size() + page.behind.size());
  filled.append(page.before).append(json).append(page.behind);
  return filled;
}

}  // namespace

std::optional<std::string> ReadReportTemplate() {
  std::ifstream stream(SharedFile("report_template.html"), std::ios::binary);
  if (!stream) return std::nullopt;
  return ReadPage(stream);
}

std::string ReadPage(std::istream& stream) {
  std::ostringstream text;
  text << stream.rdbuf();
  return std::move(text).str();
}

std::string SafeInPage(std::string json) {
  if (json.find('<') == std::string::npos) return json;
  std::string safe;
  safe.reserve(json.size());
  size_t begin = 0;
  for (size_t at = json.find('<'); at != std::string::npos; at = json.find('<', begin)) {
    safe.append(json, begin, at - begin).append("\\u003c");
    begin = at + 1;
  }
  return safe.append(json, begin);
}

PageAroundData AroundData(std::string_view page) {
  return Around(page, kDataPlace, "report_template.html has no placeholder for the data of a run");
}

std::string FillTemplate(const std::string& page, std::string_view json) { return Fill(AroundData(page), json); }

std::string FillWarnings(const std::string& page, std::string_view json) {
  return Fill(Around(page, kWarningsPlace, "report.html has no placeholder for the warnings of its run"),
              SafeInPage(std::string(json)));
}

std::optional<std::string> FillRefinement(const std::string& page, std::string_view json) {
  const size_t at = page.find(kRefinementBegin);
  const size_t begin = at + kRefinementBegin.size();
  // Its text has no '<' (SafeInPage).
  const size_t end = at == std::string::npos ? at : page.find('<', begin);
  if (end == std::string::npos) return std::nullopt;
  const std::string_view whole = page;
  return Fill({whole.substr(0, begin), whole.substr(end)}, SafeInPage(std::string(json)));
}

std::string DataOfReport(const std::string& page) {
  const size_t at = page.find(kDataBegin);
  const size_t begin = at + kDataBegin.size();
  // The data have no '<' (SafeInPage).
  const size_t end = at == std::string::npos ? at : page.find('<', begin);
  if (end == std::string::npos || page[begin] != '{') throw std::runtime_error("is not a report of a run");
  return page.substr(begin, end - begin);
}

std::string FillOtherRuns(const std::string& page, std::string_view json) {
  return Fill(Around(page, kOthersPlace, "cannot show other runs: it is from an older version"),
              SafeInPage(std::string(json)));
}

}  // namespace plslam::viewer
