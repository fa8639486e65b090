// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/comparison_figures.h"

#include <algorithm>
#include <array>
#include <optional>
#include <tuple>
#include <utility>

#include <Eigen/Geometry>

#include "tools/evaluate/compare/run_paths.h"
#include "tools/evaluate/drawing/axes.h"
#include "tools/evaluate/figures/top_view.h"

namespace plslam::evaluate {
namespace {

constexpr double kRow_pt = 22.0;
constexpr double kTop_pt = 18.0;
constexpr double kBottom_pt = 23.0;
constexpr double kSide_pt = 12.0;

const Ink kTruth{30, 30, 30};
/// Keys of the metrics that have a figure.
constexpr std::array<const char*, 5> kShown{"ate_m", "t_rel_percent", "vo_ms", "cpu_ms", "memory_mb"};

/// So fine is a figure: this share of its width is no pixel of a page.
constexpr double kFinest = 1.0 / 2000.0;

double Extent_m(const std::vector<Eigen::Vector3d>& path) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : path) box.extend(p);
  return box.isEmpty() ? 0.0 : box.diagonal().norm();
}

double DistanceToSegment_m(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d along = b - a;
  const double length2 = along.squaredNorm();
  const double share = length2 > 0.0 ? std::clamp(along.dot(p - a) / length2, 0.0, 1.0) : 0.0;
  return (a + share * along - p).norm();
}

/// The positions that a path needs to look the same in a figure: it stays within kFinest of its extent (Douglas and
/// Peucker 1973). A pose for each frame would make pages of some megabytes.
std::vector<Eigen::Vector3d> Thinned(const std::vector<Eigen::Vector3d>& path) {
  if (path.size() < 3) return path;
  const double tolerance_m = kFinest * Extent_m(path);
  std::vector<bool> kept(path.size(), false);
  kept.front() = kept.back() = true;
  std::vector<std::pair<size_t, size_t>> parts{{0, path.size() - 1}};
  while (!parts.empty()) {
    const auto [from, to] = parts.back();
    parts.pop_back();
    size_t farthest = from;
    double distance_m = tolerance_m;
    for (size_t i = from + 1; i < to; ++i) {
      const double d = DistanceToSegment_m(path[i], path[from], path[to]);
      if (d > distance_m) std::tie(distance_m, farthest) = std::pair(d, i);
    }
    if (farthest == from) continue;
    kept[farthest] = true;
    parts.emplace_back(from, farthest);
    parts.emplace_back(farthest, to);
  }
  std::vector<Eigen::Vector3d> thinned;
  for (size_t i = 0; i < path.size(); ++i) {
    if (kept[i]) thinned.push_back(path[i]);
  }
  return thinned;
}

/// The typical run of the group, if it played that (empty: anything), else the first completed one that did; or
/// nullptr.
const RunRecord* RunThatPlayed(const RunGroup& group, const std::string& played) {
  const RunRecord* typical = group.Typical();
  if (typical == nullptr || played.empty() || typical->played == played) return typical;
  for (const RunRecord& run : group.runs) {
    if (run.completed && run.played == played) return &run;
  }
  return nullptr;
}

/// Everything in the w of the first run (BaseFromOther).
std::vector<NamedPath> PathsOf(const std::vector<const RunGroup*>& groups) {
  std::vector<NamedPath> paths;
  std::optional<Run> base;
  std::string played;
  for (size_t i = 0; i < groups.size(); ++i) {
    const RunRecord* run = RunThatPlayed(*groups[i], played);
    if (run == nullptr) continue;
    played = run->played;
    const std::optional<Run> read = FindRunPaths(run->folder);
    if (!read) continue;
    if (!base) {
      base = read;
      if (const auto T_truth_w = TruthFromMap(*base)) {
        const SE3 T_w_truth = T_truth_w->Inverse();
        paths.push_back({"truth", Thinned(PositionsOf(*base->truth, T_w_truth)), {kTruth, 1.8, false}});
      }
    }
    const SE3 T_w_estimate = BaseFromOther(*base, *read);
    paths.push_back(
        {groups[i]->label, Thinned(PositionsOf(*read->trajectory, T_w_estimate)), {InkOf(i), 0.9, false}});
  }
  return paths;
}

std::vector<DotRow> RowsOf(const std::vector<const RunGroup*>& groups, size_t metric) {
  std::vector<DotRow> rows;
  for (size_t i = 0; i < groups.size(); ++i) {
    DotRow row{groups[i]->label, groups[i]->Values(metric), groups[i]->metrics[metric].median, InkOf(i)};
    if (!row.values.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

bool IsShown(const Metric& metric) { return std::find(kShown.begin(), kShown.end(), metric.key) != kShown.end(); }

}  // namespace

Ink InkOf(size_t i) {
  static constexpr std::array<Ink, 7> kInks{
      {{0, 114, 178}, {213, 94, 0}, {0, 158, 115}, {204, 121, 167}, {230, 159, 0}, {86, 180, 233}, {90, 90, 90}}};
  return kInks[i % kInks.size()];
}

Drawing DotFigure(const std::string& title, const std::string& axis, const std::vector<DotRow>& rows) {
  const double height = kRow_pt * static_cast<double>(rows.size());
  Drawing drawing;
  drawing.size = {kColumn_pt, kTop_pt + height + kBottom_pt};
  AddTitle(drawing, title);
  double largest = 1e-9;
  for (const DotRow& row : rows) {
    for (const double value : row.values) largest = std::max(largest, value);
  }
  Axes axes(drawing, {{kSide_pt, kTop_pt}, {kColumn_pt - 2.0 * kSide_pt, height}}, {0.0, 1.08 * largest},
            {0.0, height});
  axes.DrawGrid(axis, "");
  for (size_t i = 0; i < rows.size(); ++i) {
    // The name above, the dots below it.
    const double top = height - kRow_pt * static_cast<double>(i), y = top - 0.72 * kRow_pt;
    AddText(drawing, axes.At(0.0, top - 8.0) + Place(2.0, 0.0), rows[i].name);
    for (const double value : rows[i].values) axes.DrawDots({{value, y}}, 2.0, rows[i].ink);
    if (rows[i].values.empty()) continue;
    axes.DrawSegments({{Eigen::Vector2d(rows[i].median, y - 4.5), Eigen::Vector2d(rows[i].median, y + 4.5)}},
                      {{0, 0, 0}, 1.0, false});
  }
  axes.DrawFrame();
  return drawing;
}

std::vector<NamedDrawing> ComparisonFigures(const std::vector<const RunGroup*>& groups) {
  std::vector<NamedDrawing> figures;
  const std::vector<NamedPath> paths = PathsOf(groups);
  if (!paths.empty()) figures.push_back({"trajectories", TopView("trajectories", paths, nullptr)});
  for (size_t i = 0; i < Metrics().size(); ++i) {
    if (!IsShown(Metrics()[i])) continue;
    const std::vector<DotRow> rows = RowsOf(groups, i);
    if (!rows.empty())
      figures.push_back({Metrics()[i].key, DotFigure(Metrics()[i].name, NameWithUnit(Metrics()[i]), rows)});
  }
  return figures;
}

}  // namespace plslam::evaluate
