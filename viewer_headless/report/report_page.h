#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace plslam {

/// The page that shows a report, as the build has bundled it: `report_template.html` in `share/plslam` beside the folder of
/// this program. nullopt where it was built without (docs/viewer.md).
std::optional<std::string> ReadReportTemplate();

/// The page with the data inside, so that it needs nothing else. Throws std::runtime_error where the template is none.
std::string FillTemplate(const std::string& page, std::string_view json);

}  // namespace plslam
