// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace plslam::viewer {

/// The page that shows a report, as the build has bundled it: `report_template.html` in `share/plslam` beside the
/// folder of this program. nullopt where it was built without (docs/viewer.md).
std::optional<std::string> ReadReportTemplate();

/// A page, template or report, from its file.
std::string ReadPage(std::istream& stream);

/// JSON as the page can hold it: no text in it ends the element that it stands in.
std::string SafeInPage(std::string json);

/// The template before and behind the data of a run, which with them inside needs nothing else. Throws
/// std::runtime_error where it is none.
struct PageAroundData {
  std::string_view before, behind;
};
PageAroundData AroundData(std::string_view page);

/// The page with the data inside.
std::string FillTemplate(const std::string& page, std::string_view json);

/// A report with these warnings (a list as in summary.json) in the place of those that the viewer told: `plslam run`
/// alone knows the whole run, its files evaluated. Throws std::runtime_error where the page has no place for them.
std::string FillWarnings(const std::string& page, std::string_view json);

/// The data in a report. Throws std::runtime_error where it has none: it is no report of a run that has ended.
std::string DataOfReport(const std::string& page);

/// A report with the maps of other runs (others.js) beside its own. Throws std::runtime_error where the page has no
/// place for them.
std::string FillOtherRuns(const std::string& page, std::string_view json);

}  // namespace plslam::viewer
