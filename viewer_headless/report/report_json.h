// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "viewer_headless/report/report_data.h"

namespace plslam {

/// The data as the page reads it: JSON in UTF-8 without '<', so that it can stand inside a page. A column is
/// `{"type": "f32", "width": 3, "data": BASE64}`, little endian. Names that are not UTF-8 are repaired, numbers that
/// are not finite are null. Features of pictures stand in 32nds of a pixel, disparity 65535 for none.
std::string ReportJson(const ReportData& data);

}  // namespace plslam
