// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <istream>
#include <optional>
#include <string>
#include <string_view>

namespace plslam::viewer {

/// Reads the page that shows a report, as bundled by the build: `report_template.html` in `share/plslam` beside the
/// folder of this program. Returns nullopt if it was built without (docs/viewer.md).
std::optional<std::string> ReadReportTemplate();

/// A page, template or report, from its file.
std::string ReadPage(std::istream& stream);

/// Returns JSON that can be embedded in the page: no text in it ends its element.
std::string SafeInPage(std::string json);

/// The template before and after the data of a run; with the data in between, the page is self-contained. Throws
/// std::runtime_error if the page is no template.
struct PageAroundData {
  std::string_view before, behind;
};
PageAroundData AroundData(std::string_view page);

/// The page with the data inside.
std::string FillTemplate(const std::string& page, std::string_view json);

/// Returns a report whose warnings are replaced by these (a list as in summary.json): only `plslam run` has the whole
/// run with its evaluated files. Throws std::runtime_error if the page has no slot for them.
std::string FillWarnings(const std::string& page, std::string_view json);

/// Returns a report with the summary of a refinement (summary.json of `plslam refine`) instead of the one that it may
/// have; nullopt if the page has no slot for it: it is from an older version.
std::optional<std::string> FillRefinement(const std::string& page, std::string_view json);

/// Returns the data of a report. Throws std::runtime_error if it has none: it is no report of a completed run.
std::string DataOfReport(const std::string& page);

/// Returns a report with the maps of other runs (others.js) beside its own. Throws std::runtime_error if the page has
/// no slot for them.
std::string FillOtherRuns(const std::string& page, std::string_view json);

}  // namespace plslam::viewer
