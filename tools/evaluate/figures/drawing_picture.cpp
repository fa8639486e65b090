// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/evaluate/figures/drawing.h"

namespace plslam {
namespace {

// Coordinates go to OpenCV with 4 fractional bits.
constexpr int kShift = 4;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
// Of that face at scale 1, and of a face of type by its size.
constexpr double kCapitals_px = 21.0;
constexpr double kCapitalShare = 0.70;
constexpr double kStrokeShare = 0.095;
constexpr double kDash_pt = 3.0;
constexpr double kDashGap_pt = 2.0;

cv::Scalar Bgr(const Ink& ink) { return {1.0 * ink[2], 1.0 * ink[1], 1.0 * ink[0]}; }

double FontScale(double size_px) { return kCapitalShare * size_px / kCapitals_px; }

class Painter {
 public:
  Painter(cv::Mat& picture, double pixels_per_pt) : picture_(picture), scale_(pixels_per_pt) {}

  void operator()(const DrawnPath& path) {
    if (path.places.empty()) return;
    std::vector<cv::Point> pixels;
    for (const Place& place : path.places) pixels.push_back(Fixed(place));
    if (path.fill) cv::fillPoly(picture_, std::vector{pixels}, Bgr(*path.fill), cv::LINE_AA, kShift);
    if (path.stroke.width_pt <= 0.0) return;
    if (path.fill) pixels.push_back(pixels.front());
    if (path.stroke.dashed) return Dash(path);
    cv::polylines(picture_, pixels, false, Bgr(path.stroke.ink), Thickness(path.stroke), cv::LINE_AA, kShift);
  }

  void operator()(const DrawnSegments& segments) {
    for (const auto& [p, q] : segments.segments) {
      if (segments.stroke.dashed) {
        Dash({{p, q}, segments.stroke, std::nullopt});
      } else {
        Line(p, q, segments.stroke);
      }
    }
  }

  void operator()(const DrawnDots& dots) {
    const int radius = std::max(1, static_cast<int>(std::lround(dots.radius_pt * scale_ * (1 << kShift))));
    for (const Place& place : dots.places) {
      cv::circle(picture_, Fixed(place), radius, Bgr(dots.ink), cv::FILLED, cv::LINE_AA, kShift);
    }
  }

  void operator()(const DrawnText& text) {
    const double size_px = text.size_pt * scale_;
    const int thickness = std::max(1, static_cast<int>(std::lround(kStrokeShare * size_px)));
    int baseline = 0;
    const cv::Size size = cv::getTextSize(text.text, kFont, FontScale(size_px), thickness, &baseline);
    const cv::Point at(static_cast<int>(std::lround(text.at.x() * scale_ - text.anchor * size.width)),
                       static_cast<int>(std::lround(text.at.y() * scale_)));
    cv::putText(picture_, text.text, at, kFont, FontScale(size_px), Bgr(text.ink), thickness, cv::LINE_AA);
  }

  void operator()(const DrawnImage& image) {
    const auto px = [this](double pt) { return static_cast<int>(std::lround(pt * scale_)); };
    const cv::Rect box(px(image.corner.x()), px(image.corner.y()), px(image.size.x()), px(image.size.y()));
    const cv::Rect inside = box & cv::Rect({}, picture_.size());
    if (inside.empty() || image.image.empty()) return;
    cv::Mat colour = image.image, stretched;
    if (colour.channels() == 1) cv::cvtColor(image.image, colour, cv::COLOR_GRAY2BGR);
    const bool larger = box.width > colour.cols;
    cv::resize(colour, stretched, box.size(), 0, 0, larger ? cv::INTER_NEAREST : cv::INTER_AREA);
    stretched(inside - box.tl()).copyTo(picture_(inside));
  }

 private:
  cv::Point Fixed(const Place& place) const {
    // Far outside the picture nothing is seen, and the fixed-point numbers would overflow.
    const auto fix = [this](double pt) {
      return static_cast<int>(std::lround(std::clamp(pt * scale_, -1e5, 1e5) * (1 << kShift)));
    };
    return {fix(place.x()), fix(place.y())};
  }

  int Thickness(const Stroke& stroke) const {
    return std::max(1, static_cast<int>(std::lround(stroke.width_pt * scale_)));
  }

  void Line(const Place& p, const Place& q, const Stroke& stroke) {
    cv::line(picture_, Fixed(p), Fixed(q), Bgr(stroke.ink), Thickness(stroke), cv::LINE_AA, kShift);
  }

  /// The pattern runs on over the corners.
  void Dash(const DrawnPath& path) {
    constexpr double kPeriod = kDash_pt + kDashGap_pt;
    double done = 0.0;
    for (size_t i = 1; i < path.places.size(); ++i) {
      const Place &p = path.places[i - 1], &q = path.places[i];
      const double length = (q - p).norm();
      if (!(length > 0.0)) continue;
      for (double at = 0.0; at < length;) {
        const double phase = std::fmod(done + at, kPeriod);
        const bool on = phase < kDash_pt;
        const double end = std::min(length, at + (on ? kDash_pt : kPeriod) - phase + 1e-9);
        if (on) Line(p + (q - p) * (at / length), p + (q - p) * (end / length), path.stroke);
        at = end;
      }
      done += length;
    }
  }

  cv::Mat& picture_;
  double scale_;
};

}  // namespace

cv::Mat ToPicture(const Drawing& drawing, double pixels_per_pt) {
  const auto px = [&](double pt) { return std::max(1, static_cast<int>(std::lround(pt * pixels_per_pt))); };
  cv::Mat picture(px(drawing.size.y()), px(drawing.size.x()), CV_8UC3, cv::Scalar::all(255));
  Painter painter(picture, pixels_per_pt);
  for (const auto& shape : drawing.shapes) std::visit(painter, shape);
  return picture;
}

double TextWidth(const std::string& text, double size_pt) {
  // Large, so that whole pixels do not show.
  constexpr double kSize_px = 200.0;
  int baseline = 0;
  const cv::Size size = cv::getTextSize(text, kFont, FontScale(kSize_px), 1, &baseline);
  return 1.05 * size.width * size_pt / kSize_px;
}

}  // namespace plslam
