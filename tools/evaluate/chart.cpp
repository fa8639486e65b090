// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

const cv::Scalar kFrame(90, 90, 90);
const cv::Scalar kGrid(228, 228, 228);
const cv::Scalar kInk(40, 40, 40);
constexpr int kMarkSpacing_px = 130;
constexpr double kFontScale = 0.9;
// Coordinates go to OpenCV with 4 fractional bits.
constexpr int kShift = 4;

cv::Point Fixed(const cv::Point2d& p) {
  // Far outside the picture nothing is seen, and the fixed-point numbers would overflow.
  const auto fix = [](double v) { return static_cast<int>(std::lround(std::clamp(v, -1e5, 1e5) * (1 << kShift))); };
  return {fix(p.x), fix(p.y)};
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

std::vector<double> Marks(const Range& range, int max_marks) {
  std::vector<double> marks;
  const double step = MarkDistance(range.max - range.min, max_marks);
  // Counted in whole steps, so that marks are round and none is lost to rounding.
  const double last = std::floor(range.max / step + 1e-9);
  for (double k = std::ceil(range.min / step - 1e-9); k <= last; ++k) marks.push_back(k * step);
  return marks;
}

std::string MarkText(double value) { return fmt::format("{:.6g}", std::abs(value) < 1e-12 ? 0.0 : value); }

Chart::Chart(cv::Mat& picture, const cv::Rect& area, const Range& x, const Range& y)
    : picture_(picture), area_(area), x_(x), y_(y) {}

cv::Point2d Chart::Pixel(const cv::Point2d& data) const {
  return {area_.x + area_.width * (data.x - x_.min) / (x_.max - x_.min),
          area_.y + area_.height * (y_.max - data.y) / (y_.max - y_.min)};
}

// The text lies `share_left` of its width left of `at`, and `share_up` of its height above.
void Chart::Text(const std::string& text, cv::Point2d at, double share_left, double share_up) {
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kFontScale, 2, &baseline);
  const cv::Point corner(static_cast<int>(at.x - share_left * size.width),
                         static_cast<int>(at.y + (1.0 - share_up) * size.height));
  cv::putText(picture_, text, corner, cv::FONT_HERSHEY_SIMPLEX, kFontScale, kInk, 2, cv::LINE_AA);
}

void Chart::DrawGrid(const std::string& x_name, const std::string& y_name) {
  for (const double mark : Marks(x_, area_.width / kMarkSpacing_px)) {
    const double x = Pixel({mark, y_.min}).x;
    cv::line(picture_, Fixed({x, 1.0 * area_.y}), Fixed({x, 1.0 * area_.br().y}), kGrid, 2, cv::LINE_AA, kShift);
    Text(MarkText(mark), {x, area_.br().y + 14.0}, 0.5, 0.0);
  }
  for (const double mark : Marks(y_, area_.height / (kMarkSpacing_px / 2))) {
    const double y = Pixel({x_.min, mark}).y;
    cv::line(picture_, Fixed({1.0 * area_.x, y}), Fixed({1.0 * area_.br().x, y}), kGrid, 2, cv::LINE_AA, kShift);
    Text(MarkText(mark), {area_.x - 12.0, y}, 1.0, 0.5);
  }
  cv::rectangle(picture_, area_, kFrame, 2);
  Text(x_name, {area_.x + 0.5 * area_.width, area_.br().y + 54.0}, 0.5, 0.0);
  Text(y_name, {area_.x - 12.0, area_.y - 20.0}, 0.5, 1.0);
}

void Chart::DrawLine(const std::vector<cv::Point2d>& points, const cv::Scalar& colour, double thickness_px) {
  std::vector<cv::Point> pixels;
  pixels.reserve(points.size());
  for (const cv::Point2d& point : points) pixels.push_back(Fixed(Pixel(point)));
  cv::polylines(picture_, pixels, false, colour, static_cast<int>(2.0 * thickness_px), cv::LINE_AA, kShift);
}

void Chart::DrawMarker(const cv::Point2d& point, const cv::Scalar& colour) {
  const cv::Point at = Fixed(Pixel(point));
  cv::circle(picture_, at, 11 << kShift, cv::Scalar::all(255), cv::FILLED, cv::LINE_AA, kShift);
  cv::circle(picture_, at, 10 << kShift, colour, 5, cv::LINE_AA, kShift);
}

void Chart::DrawLegend(const std::vector<std::pair<std::string, cv::Scalar>>& entries) {
  double x = area_.br().x;
  const double y = area_.y - 28.0;
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    int baseline = 0;
    x -= cv::getTextSize(entry->first, cv::FONT_HERSHEY_SIMPLEX, kFontScale, 2, &baseline).width;
    Text(entry->first, {x, y}, 0.0, 0.5);
    cv::line(picture_, Fixed({x - 80.0, y}), Fixed({x - 18.0, y}), entry->second, 6, cv::LINE_AA, kShift);
    x -= 120.0;
  }
}

}  // namespace plslam
