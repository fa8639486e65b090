// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/runtime_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/run/process_names.h"
#include "tools/evaluate/drawing/axes.h"

namespace plslam::evaluate {
namespace {

using nlohmann::json;

constexpr double kRow_pt = 10.0;
constexpr double kNames_pt = 78.0;
constexpr double kValues_pt = 56.0;
constexpr double kRowsTop_pt = 30.0;
constexpr double kRowsBottom_pt = 23.0;
constexpr double kSmallest_ms = 0.01;
const Ink kMedian{31, 80, 180};
const Ink kCpu{200, 100, 20};
const Ink kText{40, 40, 40};

struct Row {
  std::string name;
  /// 0: a heading.
  double value_ms = 0.0;
  /// 95 % quantile; 0: there is none.
  double high_ms = 0.0;
  Ink ink = kMedian;
};

std::string NameOf(std::string key) {
  if (key.ends_with("_ms")) key.resize(key.size() - 3);
  std::replace(key.begin(), key.end(), '_', ' ');
  return key;
}

/// Members with quantiles, those that took any time.
std::vector<Row> QuantileRows(const json& summary, const char* part) {
  std::vector<Row> rows;
  const json members = summary.value(part, json::object());
  if (!members.is_object()) return rows;
  for (const auto& [key, value] : members.items()) {
    if (!value.is_object() || !value.contains("median") || !value.contains("p95")) continue;
    const Row row{NameOf(key), value["median"].get<double>(), value["p95"].get<double>(), kMedian};
    if (row.high_ms > 0.0) rows.push_back(row);
  }
  // Sums last.
  std::stable_partition(rows.begin(), rows.end(),
                        [](const Row& r) { return r.name != stage_name::kTotal && r.name != stage_name::kUpdate; });
  return rows;
}

std::vector<Row> CpuRows(const json& summary) {
  std::vector<Row> rows;
  const json processes = summary.value("processes", json::object());
  for (const auto& [name, process] : processes.items()) {
    const double ms = process.value("cpu_ms_per_frame", 0.0);
    if (ms > 0.0) rows.push_back({name, ms, 0.0, kCpu});
  }
  return rows;
}

void Append(const std::string& heading, const std::vector<Row>& part, std::vector<Row>& rows) {
  if (part.empty()) return;
  rows.push_back({heading, 0.0, 0.0, kText});
  rows.insert(rows.end(), part.begin(), part.end());
}

std::vector<Row> RowsOf(const json& summary) {
  std::vector<Row> rows;
  Append("odometry, wall time per frame", QuantileRows(summary, "stage_ms"), rows);
  Append("mapping, wall time per keyframe", QuantileRows(summary, "map"), rows);
  Append("loop closing, wall time per keyframe", QuantileRows(summary, "loop_closing"), rows);
  Append("processes, CPU time per frame", CpuRows(summary), rows);
  return rows;
}

Range RangeOf(const std::vector<Row>& rows) {
  double low = 1.0, high = 10.0;
  for (const Row& row : rows) {
    if (row.value_ms > 0.0) low = std::min(low, row.value_ms);
    high = std::max({high, row.value_ms, row.high_ms});
  }
  return {std::pow(10.0, std::floor(std::log10(std::max(low, kSmallest_ms)))), 1.2 * high};
}

std::string ValueText(double ms) {
  return ms >= 99.95   ? fmt::format("{:.0f}", ms)
         : ms >= 0.995 ? fmt::format("{:.3g}", ms)
                       : fmt::format("{:.2f}", ms);
}

void DrawRow(const Row& row, double base_y, double y, const Range& range, const Axes& axes, Drawing& drawing) {
  if (row.value_ms <= 0.0 && row.high_ms <= 0.0)
    return AddText(drawing, {2.0, base_y}, row.name, 0.0, kType_pt, {0, 0, 0});
  AddText(drawing, {kNames_pt - 4.0, base_y}, row.name, 1.0);
  const double value = std::max(row.value_ms, range.min);
  const Place at = axes.At(value, y);
  if (row.high_ms > value) {
    drawing.shapes.emplace_back(DrawnSegments{{{at, axes.At(row.high_ms, y)}}, {row.ink, 1.2, false}});
  }
  drawing.shapes.emplace_back(DrawnDots{{at}, 2.2, row.ink});
  const std::string high = row.high_ms > 0.0 ? fmt::format(" ({})", ValueText(row.high_ms)) : "";
  AddText(drawing, {kColumn_pt - 2.0, base_y}, ValueText(row.value_ms) + high, 1.0);
}

}  // namespace

Drawing RuntimeFigure(const std::string& title, const json& summary) {
  const std::vector<Row> rows = RowsOf(summary);
  const double height = kRow_pt * static_cast<double>(rows.size()) + 4.0;
  Drawing drawing;
  drawing.size = {kColumn_pt, kRowsTop_pt + height + kRowsBottom_pt};
  AddTitle(drawing, title);
  AddText(drawing, {kColumn_pt - 2.0, 24.0}, "ms: median (95 %)", 1.0);
  const Range x = RangeOf(rows);
  const Range y{0.0, height};
  Axes axes(drawing, {{kNames_pt, kRowsTop_pt}, {kColumn_pt - kNames_pt - kValues_pt, height}}, x, y, true);
  axes.DrawGrid("time [ms]", "");
  for (size_t i = 0; i < rows.size(); ++i) {
    const double middle = kRow_pt * (static_cast<double>(i) + 0.5) + 2.0;
    DrawRow(rows[i], kRowsTop_pt + middle + 0.35 * kType_pt, height - middle, x, axes, drawing);
  }
  return drawing;
}

}  // namespace plslam::evaluate
