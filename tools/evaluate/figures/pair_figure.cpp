// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/figures/pair_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/evaluate/drawing/axes.h"

namespace plslam::evaluate {
namespace {

constexpr double kWide = 1.8;
constexpr double kPairTop_pt = 27.0;
constexpr double kPairGap_pt = 4.0;
constexpr double kName_pt = 9.0;
constexpr size_t kMostJoined = 30;
const Ink kAlone{170, 170, 170};

/// From blue over green and yellow to red, dark enough on grey.
Ink Rainbow(double share) {
  const double hue = 4.0 * std::clamp(share, 0.0, 1.0);
  const auto channel = [](double value) {
    return static_cast<uint8_t>(std::lround(235.0 * std::clamp(value, 0.0, 1.0)));
  };
  return {channel(2.0 - std::abs(hue - 4.0)), channel(2.0 - std::abs(hue - 2.0)), channel(2.0 - std::abs(hue))};
}

/// An image of the pair in the drawing.
struct Frame {
  const PairedImage& shown;
  Place corner;
  double pt_per_px;
  Range columns;

  Place At(const Eigen::Vector2d& px) const { return corner + pt_per_px * (px + Eigen::Vector2d(0.5, 0.5)); }
  /// Small images have thin marks.
  double MarkScale() const { return Size().x() > 0.7 * kColumn_pt ? 1.0 : 0.65; }
  Place Size() const { return pt_per_px * Place(shown.image.cols, shown.image.rows); }
  /// The colour depends on the position within the columns that have shared features.
  Ink ColourAt(const Eigen::Vector2d& px) const {
    return Rainbow((px.x() - columns.min) / std::max(columns.max - columns.min, 1.0));
  }
  const StereoPoint& Point(int i) const { return shown.features->points[static_cast<size_t>(i)]; }
  const Segment2& Segment(int i) const { return shown.features->lines[static_cast<size_t>(i)].left.segment; }
};

/// From the first to the last column with a shared point of the first image.
Range ColumnsOf(const FeaturesView& features, const SameFeatures& same) {
  Range columns{1e9, -1e9};
  for (const auto& [a, b] : same.points) {
    const double u = features.points[static_cast<size_t>(a)].left.px.x();
    columns = {std::min(columns.min, u), std::max(columns.max, u)};
  }
  return columns;
}

/// Returns a lighter image, so that colours stand out.
cv::Mat Faded(const cv::Mat& image) {
  cv::Mat faded;
  image.convertTo(faded, CV_8U, 0.65, 80.0);
  return faded;
}

void DrawFrame(const Frame& frame, Drawing& drawing) {
  drawing.shapes.emplace_back(DrawnImage{frame.corner, frame.Size(), Faded(frame.shown.image)});
  DrawnDots dots{{}, 0.45 * frame.MarkScale(), kAlone};
  for (const StereoPoint& point : frame.shown.features->points) dots.places.push_back(frame.At(point.left.px));
  drawing.shapes.emplace_back(std::move(dots));
  DrawnSegments segments{{}, {kAlone, 0.5 * frame.MarkScale(), false}};
  for (const StereoLine& line : frame.shown.features->lines) {
    segments.segments.push_back({frame.At(line.left.segment.p), frame.At(line.left.segment.q)});
  }
  drawing.shapes.emplace_back(std::move(segments));
  AddText(drawing, {frame.corner.x(), frame.corner.y() + frame.Size().y() + kName_pt - 2.0}, frame.shown.name);
}

void DrawJoins(const Frame& first, const Frame& second, const SameFeatures& same, Drawing& drawing) {
  const size_t step = std::max<size_t>(1, (same.points.size() + kMostJoined - 1) / kMostJoined);
  for (size_t i = 0; i < same.points.size(); i += step) {
    const auto& [a, b] = same.points[i];
    const Eigen::Vector2d& px = first.Point(a).left.px;
    drawing.shapes.emplace_back(
        DrawnSegments{{{first.At(px), second.At(second.Point(b).left.px)}}, {first.ColourAt(px), 0.35, false}});
  }
}

void DrawSame(const Frame& first, const Frame& second, const SameFeatures& same, Drawing& drawing) {
  for (const auto& [a, b] : same.lines) {
    const Segment2 &p = first.Segment(a), &q = second.Segment(b);
    const Stroke stroke{first.ColourAt(0.5 * (p.p + p.q)), 1.3 * first.MarkScale(), false};
    drawing.shapes.emplace_back(
        DrawnSegments{{{first.At(p.p), first.At(p.q)}, {second.At(q.p), second.At(q.q)}}, stroke});
  }
  for (const auto& [a, b] : same.points) {
    const Eigen::Vector2d& px = first.Point(a).left.px;
    drawing.shapes.emplace_back(
        DrawnDots{{first.At(px), second.At(second.Point(b).left.px)}, first.MarkScale(), first.ColourAt(px)});
  }
}

std::vector<std::pair<int, int>> SameIds(const std::vector<LandmarkId>& a, const std::vector<LandmarkId>& b) {
  std::map<LandmarkId, int> place_of;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i] >= 0) place_of[a[i]] = static_cast<int>(i);
  }
  std::vector<std::pair<int, int>> same;
  for (size_t i = 0; i < b.size(); ++i) {
    const auto place = place_of.find(b[i]);
    if (b[i] >= 0 && place != place_of.end()) same.emplace_back(place->second, static_cast<int>(i));
  }
  return same;
}

}  // namespace

std::optional<std::pair<KeyframeId, KeyframeId>> PairWorthShowing(const Map& map) {
  for (size_t i = map.loops().size(); i-- > 0;) {
    const LoopEdge& loop = map.loops()[i];
    if (map.FindKeyframe(loop.old_keyframe_id) != nullptr && map.FindKeyframe(loop.keyframe_id) != nullptr) {
      return std::pair{loop.old_keyframe_id, loop.keyframe_id};
    }
  }
  if (map.keyframes().empty()) return std::nullopt;
  auto middle = map.keyframes().begin();
  std::advance(middle, static_cast<std::ptrdiff_t>(map.keyframes().size() / 2));
  const auto neighbours = map.Neighbours(middle->first, 1);
  if (neighbours.empty()) return std::nullopt;
  const auto steps = [&middle](KeyframeId id) { return std::abs(id.value - middle->first.value); };
  KeyframeId best = neighbours.front().keyframe_id;
  for (const Map::Neighbour& other : neighbours) {
    if (other.shared < Map::kEssential) break;
    if (steps(other.keyframe_id) > steps(best)) best = other.keyframe_id;
  }
  return std::pair{std::min(best, middle->first), std::max(best, middle->first)};
}

SameFeatures SharedBy(const Map& map, KeyframeId a, KeyframeId b) {
  const Map::FeatureLandmarks &of_a = map.LandmarksOf(a), &of_b = map.LandmarksOf(b);
  return {SameIds(of_a.points, of_b.points), SameIds(of_a.lines, of_b.lines)};
}

Drawing PairFigure(const std::string& title, const PairedImage& first, const PairedImage& second,
                   const SameFeatures& same) {
  const bool above = first.image.cols > kWide * first.image.rows;
  const double width = above ? kColumn_pt : 0.5 * (kColumn_pt - kPairGap_pt);
  const Frame a{first, {0.0, kPairTop_pt}, width / first.image.cols, ColumnsOf(*first.features, same)};
  const double height = a.Size().y();
  const Place shift = above ? Place(0.0, height + kName_pt + kPairGap_pt) : Place(width + kPairGap_pt, 0.0);
  const Frame b{second, a.corner + shift, width / second.image.cols, {}};
  Drawing drawing;
  drawing.size = {kColumn_pt, b.corner.y() + height + kName_pt + 1.0};
  AddTitle(drawing, title);
  AddText(drawing, {2.0, 22.0}, fmt::format("shared: points {}, lines {}", same.points.size(), same.lines.size()));
  DrawFrame(a, drawing);
  DrawFrame(b, drawing);
  DrawJoins(a, b, same, drawing);
  DrawSame(a, b, same, drawing);
  return drawing;
}

}  // namespace plslam::evaluate
