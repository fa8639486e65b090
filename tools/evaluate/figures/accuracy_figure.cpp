// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/accuracy_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/evaluate/drawing/axes.h"

namespace plslam::evaluate {
namespace {

constexpr double kLegendLine_pt = 32.0;
constexpr double kErrorHeight_pt = 48.0;
/// From one pair of axes down to the next: marks and name of the upper one, legend of the lower one.
constexpr double kBetween_pt = 40.0;
constexpr double kBelow_pt = 23.0;

const Stroke kTruth{{110, 110, 110}, 1.6, false};
const Stroke kEstimate{{31, 80, 180}, 0.9, false};
const Stroke kError{{214, 39, 40}, 0.9, false};

struct Paths {
  std::vector<Eigen::Vector2d> truth;
  std::vector<Eigen::Vector2d> estimate;
};

/// The two axes of largest extent, in the order of their names.
std::array<int, 2> TopViewAxes(const PosePairs& pairs) {
  Eigen::Vector3d low = pairs[0].truth.translation(), high = low;
  for (const PosePair& pair : pairs) {
    low = low.cwiseMin(pair.truth.translation());
    high = high.cwiseMax(pair.truth.translation());
  }
  int smallest = 0;
  (high - low).minCoeff(&smallest);
  if (smallest == 0) return {1, 2};
  return smallest == 1 ? std::array<int, 2>{0, 2} : std::array<int, 2>{0, 1};
}

Paths AlignedPaths(const Accuracy& accuracy, const std::array<int, 2>& shown) {
  Paths paths;
  for (const PosePair& pair : accuracy.pairs) {
    paths.truth.emplace_back(pair.truth.translation()(shown));
    paths.estimate.emplace_back(accuracy.alignment.Apply(pair.estimate).translation()(shown));
  }
  return paths;
}

/// Returns the axes' box.
Box DrawPaths(const Accuracy& accuracy, Drawing& drawing) {
  const std::array<int, 2> shown = TopViewAxes(accuracy.pairs);
  const Paths paths = AlignedPaths(accuracy, shown);
  std::vector<Eigen::Vector2d> all = paths.truth;
  all.insert(all.end(), paths.estimate.begin(), paths.estimate.end());
  const double top = AddLegend(drawing, {2.0, kLegendLine_pt}, kColumn_pt - 4.0,
                               {{"truth", kTruth}, {"estimate (o start)", kEstimate}});
  const Plan plan = PlanAround(all, top + 6.0);
  Axes axes(drawing, plan.area, plan.x, plan.y);
  axes.DrawGrid(fmt::format("{} [m]", "xyz"[shown[0]]), fmt::format("{} [m]", "xyz"[shown[1]]));
  axes.DrawPath(paths.truth, kTruth);
  axes.DrawPath(paths.estimate, kEstimate);
  axes.DrawRing(paths.estimate[0], kEstimate.ink);
  axes.DrawFrame();
  return plan.area;
}

/// One of the two types of errors: its name, its unit, and the factor to this unit.
struct ErrorKind {
  const char* name;
  const char* unit;
  double factor;
};

void DrawErrors(const Accuracy& accuracy, const std::vector<double>& errors, const ErrorKind& kind, const Box& area,
                Drawing& drawing) {
  std::vector<Eigen::Vector2d> points;
  double highest = 0.0;
  for (size_t i = 0; i < errors.size(); ++i) {
    points.emplace_back(1e-9 * static_cast<double>(accuracy.pairs[i].t_ns - accuracy.pairs[0].t_ns),
                        kind.factor * errors[i]);
    highest = std::max(highest, points.back().y());
  }
  AddText(drawing, {area.corner.x() + 0.5 * area.size.x(), area.corner.y() - 4.0}, kind.name, 0.5);
  Axes axes(drawing, area, {0.0, std::max(accuracy.duration_s, 1e-3)}, {0.0, std::max(1.1 * highest, 1e-6)});
  axes.DrawGrid("time [s]", kind.unit);
  axes.DrawPath(points, kError);
  axes.DrawFrame();
}

}  // namespace

Drawing AccuracyFigure(const std::string& title, const Accuracy& accuracy) {
  Drawing drawing;
  drawing.size = {kColumn_pt, kLegendLine_pt};
  AddTitle(drawing, title);
  if (accuracy.pairs.empty()) {
    AddText(drawing, {2.0, 22.0}, accuracy.note);
    return drawing;
  }
  AddText(drawing, {2.0, 21.0},
          fmt::format("ATE {:.4f} m ({}), coverage {:.1f} %", accuracy.ate_m.rmse, NameOf(accuracy.alignment_kind),
                      accuracy.coverage_percent));
  const Box paths = DrawPaths(accuracy, drawing);
  const Box position{{paths.corner.x(), paths.Bottom() + kBetween_pt}, {paths.size.x(), kErrorHeight_pt}};
  const Box orientation{{paths.corner.x(), position.Bottom() + kBetween_pt}, position.size};
  DrawErrors(accuracy, accuracy.absolute.translation_m, {"position error", "[m]", 1.0}, position, drawing);
  DrawErrors(accuracy, accuracy.absolute.rotation_rad, {"orientation error", "[deg]", 180.0 / M_PI}, orientation,
             drawing);
  drawing.size.y() = orientation.Bottom() + kBelow_pt;
  return drawing;
}

}  // namespace plslam::evaluate
