// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/drawing/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plslam::evaluate {
namespace {

const Ink kFrame{90, 90, 90};
const Ink kGrid{225, 225, 225};
constexpr double kRow_pt = 10.0;
constexpr double kMarkSpacing_pt = 34.0;

// Around the axes of a plan.
constexpr double kLeft_pt = 30.0;
constexpr double kRight_pt = 6.0;
constexpr double kBottom_pt = 23.0;
constexpr double kLeastHeight_pt = 110.0;
constexpr double kMostHeight_pt = 230.0;

/// The marks of an axis, all within the range.
std::vector<double> Marks(const Range& range, int max_marks) {
  std::vector<double> marks;
  const double step = MarkDistance(range.max - range.min, max_marks);
  // Counted in whole steps, so that marks are round and none is lost to rounding.
  const double last = std::floor(range.max / step + 1e-9);
  for (double k = std::ceil(range.min / step - 1e-9); k <= last; ++k) marks.push_back(k * step);
  return marks;
}

std::string MarkText(double value) { return fmt::format("{:.6g}", std::abs(value) < 1e-12 ? 0.0 : value); }

std::vector<double> PowersOfTen(const Range& range) {
  std::vector<double> marks;
  for (double k = std::ceil(std::log10(range.min) - 1e-9); k <= std::log10(range.max) + 1e-9; ++k) {
    marks.push_back(std::pow(10.0, k));
  }
  return marks;
}

}  // namespace

double MarkDistance(double span, int max_marks) {
  const double least = span / std::max(1, max_marks - 1);
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

Axes::Axes(Drawing& drawing, const Box& area, const Range& x, const Range& y, bool log_x)
    : drawing_(drawing), area_(area), x_(x), y_(y), log_x_(log_x) {}

Place Axes::At(double x, double y) const {
  const double share = log_x_ ? std::log(x / x_.min) / std::log(x_.max / x_.min) : (x - x_.min) / (x_.max - x_.min);
  return {area_.corner.x() + area_.size.x() * share,
          area_.corner.y() + area_.size.y() * (y_.max - y) / (y_.max - y_.min)};
}

bool Axes::Contains(double x, double y) const { return x >= x_.min && x <= x_.max && y >= y_.min && y <= y_.max; }

void Axes::MarkX(double value) {
  const double x = At(value, y_.min).x();
  drawing_.shapes.emplace_back(
      DrawnSegments{{{Place(x, area_.corner.y()), Place(x, area_.Bottom())}}, {kGrid, 0.5, false}});
  AddText(drawing_, {x, area_.Bottom() + 1.35 * kType_pt}, MarkText(value), 0.5);
}

void Axes::MarkY(double value) {
  const double y = At(x_.min, value).y();
  drawing_.shapes.emplace_back(
      DrawnSegments{{{Place(area_.corner.x(), y), Place(area_.Right(), y)}}, {kGrid, 0.5, false}});
  AddText(drawing_, {area_.corner.x() - 3.0, y + 0.35 * kType_pt}, MarkText(value), 1.0);
}

void Axes::DrawGrid(const std::string& x_name, const std::string& y_name) {
  const int max_marks = std::max(3, static_cast<int>(area_.size.x() / kMarkSpacing_pt));
  for (const double mark : log_x_ ? PowersOfTen(x_) : Marks(x_, max_marks)) MarkX(mark);
  if (!y_name.empty()) {
    const int max_y_marks = std::max(3, static_cast<int>(area_.size.y() / (0.6 * kMarkSpacing_pt)));
    for (const double mark : Marks(y_, max_y_marks)) MarkY(mark);
  }
  AddText(drawing_, {area_.corner.x() + 0.5 * area_.size.x(), area_.Bottom() + 2.7 * kType_pt}, x_name, 0.5);
  AddText(drawing_, {area_.corner.x() - 3.0, area_.corner.y() - 4.0}, y_name, 0.5);
}

void Axes::DrawFrame() {
  const Place a = area_.corner, b(area_.Right(), area_.Bottom());
  drawing_.shapes.emplace_back(
      DrawnPath{{a, {b.x(), a.y()}, b, {a.x(), b.y()}, a}, {kFrame, 0.6, false}, std::nullopt});
}

void Axes::DrawPath(const std::vector<Eigen::Vector2d>& data, const Stroke& stroke) {
  DrawnPath path{{}, stroke, std::nullopt};
  for (const Eigen::Vector2d& d : data) path.places.push_back(At(d.x(), d.y()));
  drawing_.shapes.emplace_back(std::move(path));
}

void Axes::DrawDots(const std::vector<Eigen::Vector2d>& data, double radius_pt, const Ink& ink) {
  DrawnDots dots{{}, radius_pt, ink};
  for (const Eigen::Vector2d& d : data) {
    if (Contains(d.x(), d.y())) dots.places.push_back(At(d.x(), d.y()));
  }
  drawing_.shapes.emplace_back(std::move(dots));
}

void Axes::DrawSegments(const std::vector<std::array<Eigen::Vector2d, 2>>& data, const Stroke& stroke) {
  DrawnSegments segments{{}, stroke};
  for (const auto& [p, q] : data) {
    if (!Contains(p.x(), p.y()) || !Contains(q.x(), q.y())) continue;
    segments.segments.push_back({At(p.x(), p.y()), At(q.x(), q.y())});
  }
  drawing_.shapes.emplace_back(std::move(segments));
}

void Axes::DrawRing(const Eigen::Vector2d& data, const Ink& ink) {
  const Place at = At(data.x(), data.y());
  drawing_.shapes.emplace_back(DrawnDots{{at}, 2.8, ink});
  drawing_.shapes.emplace_back(DrawnDots{{at}, 1.7, {255, 255, 255}});
}

Plan PlanAround(const std::vector<Eigen::Vector2d>& positions, double top_pt) {
  constexpr double kMargin = 1.10;
  Eigen::Vector2d low = Eigen::Vector2d::Zero(), high = Eigen::Vector2d::Zero();
  if (!positions.empty()) low = high = positions[0];
  for (const Eigen::Vector2d& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector2d extent = (high - low).cwiseMax(1e-3), centre = 0.5 * (low + high);
  const double width = kColumn_pt - kLeft_pt - kRight_pt;
  const double height = std::clamp(width * extent.y() / extent.x(), kLeastHeight_pt, kMostHeight_pt);
  const double m_per_pt = kMargin * std::max(extent.x() / width, extent.y() / height);
  const Eigen::Vector2d half = 0.5 * m_per_pt * Eigen::Vector2d(width, height);
  Plan plan;
  plan.area = {{kLeft_pt, top_pt}, {width, height}};
  plan.x = {centre.x() - half.x(), centre.x() + half.x()};
  plan.y = {centre.y() - half.y(), centre.y() + half.y()};
  plan.height_pt = top_pt + height + kBottom_pt;
  return plan;
}

void AddText(Drawing& drawing, const Place& at, const std::string& text, double anchor, double size_pt,
             const Ink& ink) {
  if (!text.empty()) drawing.shapes.emplace_back(DrawnText{at, text, size_pt, anchor, ink});
}

void AddTitle(Drawing& drawing, const std::string& title) {
  constexpr double kLargest_pt = 8.0, kWidth_pt = kColumn_pt - 4.0;
  const double fitting_pt = kLargest_pt * kWidth_pt / std::max(TextWidth(title, kLargest_pt), 1.0);
  const double size_pt = std::clamp(fitting_pt, kType_pt - 1.0, kLargest_pt);
  std::string text = title;
  while (text.size() > 4 && TextWidth(text, size_pt) > kWidth_pt) text = text.substr(0, text.size() - 4) + "...";
  AddText(drawing, {2.0, 11.0}, text, 0.0, size_pt, {0, 0, 0});
}

double AddLegend(Drawing& drawing, const Place& at, double width_pt, const std::vector<LegendEntry>& entries) {
  constexpr double kSample_pt = 14.0, kGap_pt = 4.0, kBetween_pt = 10.0;
  Place place = at;
  for (const LegendEntry& entry : entries) {
    const double width = kSample_pt + kGap_pt + TextWidth(entry.name, kType_pt);
    if (place.x() > at.x() && place.x() + width > at.x() + width_pt) place = {at.x(), place.y() + kRow_pt};
    const Place left(place.x(), place.y() - 0.35 * kType_pt), right(place.x() + kSample_pt, left.y());
    if (entry.stroke.width_pt > 0.0) drawing.shapes.emplace_back(DrawnSegments{{{left, right}}, entry.stroke});
    if (entry.dot_pt > 0.0) {
      drawing.shapes.emplace_back(DrawnDots{{0.5 * (left + right)}, entry.dot_pt, entry.stroke.ink});
    }
    AddText(drawing, {right.x() + kGap_pt, place.y()}, entry.name);
    place.x() += width + kBetween_pt;
  }
  return place.y() + kRow_pt;
}

}  // namespace plslam::evaluate
