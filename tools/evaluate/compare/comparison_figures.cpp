// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/compare/comparison_figures.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>

#include "tools/evaluate/accuracy.h"
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

std::optional<Trajectory> TryRead(const std::string& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  try {
    return ReadTrajectory(path, TrajectoryFormat::kTum);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
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

/// Everything in the w of the first run, which the truth joins with the others; without truth, as it is.
std::vector<NamedPath> PathsOf(const std::vector<const RunGroup*>& groups) {
  std::vector<NamedPath> paths;
  std::optional<SE3> T_w_truth;
  std::string played;
  for (size_t i = 0; i < groups.size(); ++i) {
    const RunRecord* run = RunThatPlayed(*groups[i], played);
    if (run == nullptr) continue;
    played = run->played;
    const auto estimate = TryRead(run->folder + "/trajectory.tum");
    const auto truth = TryRead(run->folder + "/groundtruth.tum");
    if (!estimate || estimate->empty()) continue;
    SE3 T_w_estimate;
    if (truth && !truth->empty()) {
      const SE3 T_truth_estimate = EvaluateTrajectory(*estimate, *truth, {}).alignment.T_a_b;
      if (!T_w_truth) {
        T_w_truth = T_truth_estimate.Inverse();
        paths.push_back({"truth", PositionsOf(*truth, *T_w_truth), {kTruth, 1.8, false}});
      }
      T_w_estimate = *T_w_truth * T_truth_estimate;
    }
    paths.push_back({groups[i]->label, PositionsOf(*estimate, T_w_estimate), {InkOf(i), 0.9, false}});
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
