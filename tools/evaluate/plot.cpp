// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluate/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/evaluate/chart.h"

namespace plslam {
namespace {

// Drawn at twice the size and halved.
const cv::Size kPicture(2000, 2440);
const cv::Rect kPathArea(190, 190, 1740, 1240);
const cv::Rect kPositionArea(190, 1600, 1740, 270);
const cv::Rect kOrientationArea(190, 2060, 1740, 270);

const cv::Scalar kTruthColour(110, 110, 110);
const cv::Scalar kEstimateColour(190, 90, 20);
const cv::Scalar kErrorColour(50, 60, 200);

struct Paths {
  std::vector<Eigen::Vector3d> truth;
  std::vector<Eigen::Vector3d> estimate;
};

Paths AlignedPaths(const Accuracy& accuracy) {
  Paths paths;
  for (const PosePair& pair : accuracy.pairs) {
    paths.truth.push_back(pair.truth.translation());
    paths.estimate.push_back(accuracy.alignment.Apply(pair.estimate).translation());
  }
  return paths;
}

// The two axes of largest extent, in the order of their names.
std::array<int, 2> TopViewAxes(const std::vector<Eigen::Vector3d>& path) {
  Eigen::Vector3d low = path[0];
  Eigen::Vector3d high = path[0];
  for (const Eigen::Vector3d& p : path) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  int smallest = 0;
  (high - low).minCoeff(&smallest);
  if (smallest == 0) return {1, 2};
  return smallest == 1 ? std::array<int, 2>{0, 2} : std::array<int, 2>{0, 1};
}

std::vector<cv::Point2d> Flatten(const std::vector<Eigen::Vector3d>& path, const std::array<int, 2>& axes) {
  std::vector<cv::Point2d> points;
  points.reserve(path.size());
  for (const Eigen::Vector3d& p : path) points.emplace_back(p[axes[0]], p[axes[1]]);
  return points;
}

void Extend(const std::vector<cv::Point2d>& points, Range& x, Range& y) {
  for (const cv::Point2d& p : points) {
    x = {std::min(x.min, p.x), std::max(x.max, p.x)};
    y = {std::min(y.min, p.y), std::max(y.max, p.y)};
  }
}

// Widens one of the ranges until a metre is as long on both axes, with a margin around the paths.
void EqualiseScale(const cv::Rect& area, Range& x, Range& y) {
  constexpr double kMargin = 1.08;
  const double m_per_px =
      kMargin * std::max({(x.max - x.min) / area.width, (y.max - y.min) / area.height, 1e-3 / area.width});
  const auto widen = [m_per_px](Range& range, int pixels) {
    const double centre = 0.5 * (range.min + range.max);
    range = {centre - 0.5 * m_per_px * pixels, centre + 0.5 * m_per_px * pixels};
  };
  widen(x, area.width);
  widen(y, area.height);
}

void DrawPaths(const Accuracy& accuracy, cv::Mat& picture) {
  const Paths paths = AlignedPaths(accuracy);
  const std::array<int, 2> axes = TopViewAxes(paths.truth);
  const std::vector<cv::Point2d> truth = Flatten(paths.truth, axes);
  const std::vector<cv::Point2d> estimate = Flatten(paths.estimate, axes);
  Range x{truth[0].x, truth[0].x};
  Range y{truth[0].y, truth[0].y};
  Extend(truth, x, y);
  Extend(estimate, x, y);
  EqualiseScale(kPathArea, x, y);
  Chart chart(picture, kPathArea, x, y);
  chart.DrawGrid(fmt::format("{} [m]", "xyz"[axes[0]]), fmt::format("{} [m]", "xyz"[axes[1]]));
  chart.DrawLine(truth, kTruthColour, 3.0);
  chart.DrawLine(estimate, kEstimateColour, 1.5);
  chart.DrawMarker(estimate[0], kEstimateColour);
  chart.DrawLegend({{"truth", kTruthColour}, {"estimate (o start)", kEstimateColour}});
}

void DrawErrors(const Accuracy& accuracy, const std::vector<double>& errors, double unit, const char* name,
                const cv::Rect& area, cv::Mat& picture) {
  std::vector<cv::Point2d> points;
  double highest = 0.0;
  for (size_t i = 0; i < errors.size(); ++i) {
    points.emplace_back(1e-9 * static_cast<double>(accuracy.pairs[i].t_ns - accuracy.pairs[0].t_ns),
                        unit * errors[i]);
    highest = std::max(highest, points.back().y);
  }
  const Range t{0.0, std::max(accuracy.duration_s, 1e-3)};
  Chart chart(picture, area, t, {0.0, std::max(1.1 * highest, 1e-6)});
  chart.DrawGrid("time [s]", "");
  chart.DrawLine(points, kErrorColour, 1.5);
  chart.DrawLegend({{name, kErrorColour}});
}

}  // namespace

cv::Mat PlotAccuracy(const Accuracy& accuracy, const std::string& title) {
  cv::Mat picture(kPicture, CV_8UC3, cv::Scalar::all(255));
  const std::string text = accuracy.pairs.empty()
                               ? accuracy.note
                               : fmt::format("{}   ATE {:.4f} m ({}), coverage {:.1f} %", title, accuracy.ate_m.rmse,
                                             AlignmentName(accuracy.alignment_kind), accuracy.coverage_percent);
  cv::putText(picture, text, {60, 80}, cv::FONT_HERSHEY_SIMPLEX, 1.2, cv::Scalar::all(20), 3, cv::LINE_AA);
  if (!accuracy.pairs.empty()) {
    DrawPaths(accuracy, picture);
    DrawErrors(accuracy, accuracy.absolute.translation_m, 1.0, "position error [m]", kPositionArea, picture);
    DrawErrors(accuracy, accuracy.absolute.rotation_rad, 180.0 / M_PI, "orientation error [deg]", kOrientationArea,
               picture);
  }
  cv::Mat half;
  cv::resize(picture, half, kPicture / 2, 0.0, 0.0, cv::INTER_AREA);
  return half;
}

}  // namespace plslam
