// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// The data that a live page already has, so that only new data are sent. Encoded as text, "3.1.250.17.96.4".
struct ReportSince {
  int64_t run = -1;          ///< id of the stream; another one: everything is new
  int64_t stride = 1;        ///< of the frames that it has
  int64_t rows = 0;          ///< rows of frames
  int64_t map_version = -1;  ///< of the map and of the path
  int64_t picture = -1;      ///< frame of the newest picture
  int64_t surfaces = -1;     ///< version of the surfaces

  std::string Text() const;
  /// Empty text means no data yet; nullopt if the text is invalid.
  static std::optional<ReportSince> Parse(std::string_view text);
  bool operator==(const ReportSince&) const = default;
};

/// Returns the data for the page: JSON in UTF-8 without '<', so that it can be embedded in a page. A column is
/// `{"type": "f32", "width": 3, "data": BASE64}`, little endian. Names that are not UTF-8 are repaired, non-finite
/// numbers are null. Features of pictures are in 32nds of a pixel, disparity 65535 for none.
std::string ReportJson(const ReportData& data);

}  // namespace plslam::viewer
