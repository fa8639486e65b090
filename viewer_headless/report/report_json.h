// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "viewer_headless/report/report_data.h"

namespace plslam::viewer {

/// What a live page has already, so that it is sent only what is new. Travels as text, "3.1.250.17.96".
struct ReportSince {
  int64_t run = -1;          ///< which stream; another one: everything is new
  int64_t stride = 1;        ///< of the frames it has
  int64_t rows = 0;          ///< rows of frames
  int64_t map_version = -1;  ///< of the map and of the path
  int64_t picture = -1;      ///< frame of the newest picture

  std::string Text() const;
  /// Empty text is nothing yet; nullopt where it is no such text.
  static std::optional<ReportSince> Parse(std::string_view text);
  bool operator==(const ReportSince&) const = default;
};

/// The data as the page reads it: JSON in UTF-8 without '<', so that it can stand inside a page. A column is
/// `{"type": "f32", "width": 3, "data": BASE64}`, little endian. Names that are not UTF-8 are repaired, numbers that
/// are not finite are null. Features of pictures stand in 32nds of a pixel, disparity 65535 for none.
std::string ReportJson(const ReportData& data);

}  // namespace plslam::viewer
