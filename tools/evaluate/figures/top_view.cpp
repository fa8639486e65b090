// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/top_view.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/map/vertical.h"

namespace plslam::evaluate {
namespace {

const Ink kLandmark{178, 178, 178};
const Ink kLandmarkLine{120, 120, 120};
constexpr size_t kMostPoints = 20000;
constexpr double kLegendLine_pt = 22.0;
/// A path that climbs by more than this share of its length or width is seen from the side.
constexpr double kUpright = 0.75;
/// A path is called longer than wide from here on.
constexpr double kLong = 1.3;

Eigen::Vector3d ExtentAlong(const Eigen::Matrix3d& axes, const std::vector<Eigen::Vector3d>& positions) {
  if (positions.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d low = axes.transpose() * positions[0], high = low;
  for (const Eigen::Vector3d& position : positions) {
    const Eigen::Vector3d p = axes.transpose() * position;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return high - low;
}

/// Title and legend over axes of equal scale around `around`; the drawing has its size then.
Plan Begin(const std::string& title, const std::vector<LegendEntry>& legend,
           const std::vector<Eigen::Vector2d>& around, Drawing& drawing) {
  AddTitle(drawing, title);
  const double top = AddLegend(drawing, {2.0, kLegendLine_pt}, kColumn_pt - 4.0, legend);
  Plan plan = PlanAround(around, top + 6.0);
  drawing.size = {kColumn_pt, plan.height_pt};
  return plan;
}

using Edges = std::vector<std::array<Eigen::Vector2d, 2>>;

/// The map's landmarks within the axes: every `step`-th point, and lines.
struct ShownLandmarks {
  size_t step = 1;
  std::vector<Eigen::Vector2d> points;
  Edges lines;
};

bool Within(const Plan& plan, const Eigen::Vector2d& p) {
  return p.x() >= plan.x.min && p.x() <= plan.x.max && p.y() >= plan.y.min && p.y() <= plan.y.max;
}

ShownLandmarks LandmarksWithin(const Plan& plan, const Map& map, const ViewDirections& view) {
  ShownLandmarks shown;
  shown.step = (map.points().size() + kMostPoints - 1) / kMostPoints;
  size_t i = 0;
  for (const auto& [id, point] : map.points()) {
    if (i++ % shown.step == 0 && Within(plan, view(point.p_w))) shown.points.push_back(view(point.p_w));
  }
  for (const auto& [id, line] : map.lines()) {
    const std::array<Eigen::Vector2d, 2> ends{view(line.segment_w.p), view(line.segment_w.q)};
    if (Within(plan, ends[0]) && Within(plan, ends[1])) shown.lines.push_back(ends);
  }
  return shown;
}

std::vector<LegendEntry> LegendOf(const std::vector<NamedPath>& paths, const ShownLandmarks& shown) {
  std::vector<LegendEntry> legend;
  legend.reserve(paths.size() + 2);
  for (const NamedPath& path : paths) legend.push_back({path.name, path.stroke, 0.0});
  const std::string points = shown.step > 1 ? fmt::format("points (1 in {})", shown.step) : "points";
  if (!shown.points.empty()) legend.push_back({points, {kLandmark, 0.0, false}, 1.0});
  if (!shown.lines.empty()) legend.push_back({"lines", {kLandmarkLine, 0.5, false}, 0.0});
  return legend;
}

/// Pairs of keyframes that share as many landmarks, but fewer than `below`.
Edges SharedEdges(const Map& map, const ViewDirections& view, int min_shared, int below) {
  Edges edges;
  for (const auto& [id, keyframe] : map.keyframes()) {
    for (const Map::Neighbour& other : map.Neighbours(id, min_shared)) {
      if (other.keyframe_id <= id || other.shared >= below) continue;
      edges.push_back(
          {view(keyframe.T_w_kf.translation()), view(map.keyframes().at(other.keyframe_id).T_w_kf.translation())});
    }
  }
  return edges;
}

Edges EdgesBetween(const Map& map, const ViewDirections& view,
                   const std::vector<std::pair<KeyframeId, KeyframeId>>& pairs) {
  Edges edges;
  for (const auto& [a, b] : pairs) {
    const MapKeyframe *first = map.FindKeyframe(a), *second = map.FindKeyframe(b);
    if (first == nullptr || second == nullptr) continue;
    edges.push_back({view(first->T_w_kf.translation()), view(second->T_w_kf.translation())});
  }
  return edges;
}

Edges TreeEdges(const Map& map, const ViewDirections& view) {
  std::vector<std::pair<KeyframeId, KeyframeId>> pairs;
  for (const auto& [id, keyframe] : map.keyframes()) pairs.emplace_back(id, keyframe.parent_id);
  return EdgesBetween(map, view, pairs);
}

Edges LoopEdges(const Map& map, const ViewDirections& view) {
  std::vector<std::pair<KeyframeId, KeyframeId>> pairs;
  for (const LoopEdge& loop : map.loops()) pairs.emplace_back(loop.old_keyframe_id, loop.keyframe_id);
  return EdgesBetween(map, view, pairs);
}

}  // namespace

std::vector<Eigen::Vector2d> ViewDirections::operator()(const std::vector<Eigen::Vector3d>& path) const {
  std::vector<Eigen::Vector2d> flat;
  flat.reserve(path.size());
  for (const Eigen::Vector3d& p : path) flat.push_back((*this)(p));
  return flat;
}

ViewDirections ViewOf(const std::vector<Eigen::Vector3d>& positions, const Eigen::Vector3d& up_w) {
  const Eigen::Matrix3d R_w_level = LevelRotation(up_w).conjugate().toRotationMatrix();
  const Eigen::Vector3d extent = ExtentAlong(R_w_level, positions);
  const Eigen::Vector3d x = R_w_level.col(0), y = R_w_level.col(1), z = R_w_level.col(2);
  const bool level = extent.y() <= kUpright * std::max(extent.x(), extent.z());
  if (!level && extent.x() < extent.z()) return {z, -y, "z [m]", "-y [m]"};
  if (!level) return {x, -y, "x [m]", "-y [m]"};
  if (extent.z() > kLong * extent.x()) return {z, -x, "z [m]", "-x [m]"};
  return {x, z, "x [m]", "z [m]"};
}

std::vector<Eigen::Vector3d> PositionsOf(const Trajectory& trajectory, const SE3& T_w_trajectory) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(trajectory.size());
  for (const TrajectoryPose& pose : trajectory) positions.push_back(T_w_trajectory * pose.T_a_b.translation());
  return positions;
}

Drawing TopView(const std::string& title, const std::vector<NamedPath>& paths, const Map* map) {
  std::vector<Eigen::Vector3d> all;
  for (const NamedPath& path : paths) all.insert(all.end(), path.positions_w.begin(), path.positions_w.end());
  const ViewDirections view = ViewOf(all, map != nullptr ? VerticalOf(*map).up_w : Vertical().up_w);
  ShownLandmarks shown;
  // How high the legend is does not change the ranges.
  if (map != nullptr) shown = LandmarksWithin(PlanAround(view(all), 0.0), *map, view);
  Drawing drawing;
  const Plan plan = Begin(title, LegendOf(paths, shown), view(all), drawing);
  Axes axes(drawing, plan.area, plan.x, plan.y);
  axes.DrawGrid(view.right_name, view.up_name);
  axes.DrawDots(shown.points, 0.35, kLandmark);
  axes.DrawSegments(shown.lines, {kLandmarkLine, 0.5, false});
  for (const NamedPath& path : paths) axes.DrawPath(view(path.positions_w), path.stroke);
  if (!paths.empty() && !paths.back().positions_w.empty()) {
    axes.DrawRing(view(paths.back().positions_w.front()), paths.back().stroke.ink);
  }
  axes.DrawFrame();
  return drawing;
}

Drawing CovisibilityFigure(const std::string& title, const Map& map) {
  std::vector<Eigen::Vector3d> all;
  for (const auto& [id, keyframe] : map.keyframes()) all.push_back(keyframe.T_w_kf.translation());
  const ViewDirections view = ViewOf(all, VerticalOf(map).up_w);
  const Stroke covisible{{150, 214, 150}, 0.4, false}, essential{{20, 140, 60}, 0.6, false};
  const Stroke tree{{60, 60, 60}, 0.6, false}, loop{{214, 39, 40}, 1.3, false};
  const Edges loops = LoopEdges(map, view);
  std::vector<LegendEntry> legend{{"20 shared landmarks", covisible, 0.0},
                                  {"100 and more", essential, 0.0},
                                  {"spanning tree", tree, 0.0},
                                  {"keyframes", {{31, 80, 180}, 0.0, false}, 1.4}};
  if (!loops.empty()) legend.push_back({"loops", loop, 0.0});
  Drawing drawing;
  const Plan plan = Begin(title, legend, view(all), drawing);
  Axes axes(drawing, plan.area, plan.x, plan.y);
  axes.DrawGrid(view.right_name, view.up_name);
  axes.DrawSegments(SharedEdges(map, view, Map::kCovisible, Map::kEssential), covisible);
  axes.DrawSegments(SharedEdges(map, view, Map::kEssential, 1 << 30), essential);
  axes.DrawSegments(TreeEdges(map, view), tree);
  axes.DrawDots(view(all), 1.2, {31, 80, 180});
  axes.DrawSegments(loops, loop);
  for (const auto& [from, to] : loops) axes.DrawDots({from, to}, 1.5, loop.ink);
  axes.DrawFrame();
  return drawing;
}

}  // namespace plslam::evaluate
