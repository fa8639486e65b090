// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/report_since.h"

#include <fmt/format.h>

#include <array>
#include <charconv>

namespace plslam {

std::string ReportSince::Text() const {
  return fmt::format("{}.{}.{}.{}.{}", run, stride, rows, map_version, picture);
}

std::optional<ReportSince> ReportSince::Parse(std::string_view text) {
  if (text.empty()) return ReportSince();
  std::array<int64_t, 5> numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0 && (at == end || *at++ != '.')) return std::nullopt;
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    if (error != std::errc() || numbers[i] < -1) return std::nullopt;
    at = next;
  }
  if (at != end) return std::nullopt;
  return ReportSince{numbers[0], numbers[1], numbers[2], numbers[3], numbers[4]};
}

}  // namespace plslam
