// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibration/live/coverage_page.h"

#include <fmt/format.h>

#include "core/errors/error_text.h"
#include "tools/calibration/coverage.h"

namespace plslam::calibration {
namespace {

constexpr int kColumns = 16, kRows = 10, kCell = 20;

std::string CoverageSvg(const PictureTaker& taker, bool is_right) {
  const std::vector<int> counts = CountsOfCells(taker.pixels(is_right), taker.size(), kColumns, kRows);
  std::string svg = fmt::format("<figure><svg width=\"{}\" height=\"{}\">", kColumns * kCell, kRows * kCell);
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      const int n = counts[static_cast<size_t>(row * kColumns + column)];
      const char* colour = n == 0 ? "#eee" : n < 4 ? "#bcd9f5" : n < 12 ? "#6aaee8" : "#1f77c9";
      svg += fmt::format("<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>", column * kCell,
                         row * kCell, kCell - 1, kCell - 1, colour);
    }
  }
  return svg + fmt::format("</svg><figcaption>{} camera</figcaption></figure>\n", is_right ? "right" : "left");
}

}  // namespace

std::string CoveragePage(const PictureTaker& taker, const std::vector<std::string>& pictures, bool is_running) {
  std::string page = "<!DOCTYPE html>\n<html><head><meta charset=\"utf-8\"><title>Calibration</title>\n";
  if (is_running) page += "<meta http-equiv=\"refresh\" content=\"1\">\n";
  page +=
      "<style>body{font-family:sans-serif;margin:1em}figure{display:inline-block;margin:0 1em 1em 0}"
      "img{width:160px;margin:2px}</style></head><body>\n";
  page += fmt::format("<h1>{} picture{}{}</h1>\n", taker.pictures(), taker.pictures() == 1 ? "" : "s",
                      is_running ? "" : ", done");
  page += CoverageSvg(taker, false) + CoverageSvg(taker, true);
  const std::vector<std::string> missing = taker.Missing();
  page += missing.empty() ? "<p>No view is missing.</p>\n" : "<h2>Missing</h2>\n<ul>\n";
  for (const std::string& sentence : missing) page += fmt::format("<li>{}</li>\n", InHtml(sentence));
  if (!missing.empty()) page += "</ul>\n";
  for (const std::string& picture : pictures) page += fmt::format("<img src=\"{}\">\n", InHtml(picture));
  return page + "</body></html>\n";
}

}  // namespace plslam::calibration
