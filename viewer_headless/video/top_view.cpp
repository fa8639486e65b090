// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/video/top_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace plslam::viewer {
namespace {

constexpr double kMargin = 1.3;
constexpr double kGrowth = 1.25;
constexpr double kLowShare = 0.05;
constexpr double kHighShare = 0.95;
constexpr double kLeastReach_m = 1.0;
constexpr size_t kLeastPoints = 50;
constexpr int kShift = 4;
const cv::Scalar kGround(28, 24, 22);
const cv::Vec3b kPoint(120, 112, 104);
const cv::Scalar kSegment(150, 175, 120);
const cv::Scalar kPath(255, 178, 108);
const cv::Scalar kCamera(90, 200, 255);
const cv::Scalar kText(225, 225, 225);

class Projection {
 public:
  Projection(const TopViewWindow& window, const cv::Size& size)
      : centre_m_(window.centre_m()),
        middle_(0.5 * size.width, 0.5 * size.height),
        px_per_m_(std::min(size.width, size.height) / window.side_m()) {}

  double px_per_m() const { return px_per_m_; }
  cv::Point2d operator()(const Eigen::Vector3d& p_w) const {
    return {middle_.x + (p_w.x() - centre_m_.x()) * px_per_m_, middle_.y - (p_w.z() - centre_m_.y()) * px_per_m_};
  }

 private:
  Eigen::Vector2d centre_m_;
  cv::Point2d middle_;
  double px_per_m_;
};

// Fixed-point drawing overflows far outside; NaN is not below either.
bool IsDrawable(const cv::Point2d& p) { return std::abs(p.x) < 20000.0 && std::abs(p.y) < 20000.0; }

cv::Point Fixed(const cv::Point2d& p) {
  return {static_cast<int>(std::lround(p.x * (1 << kShift))), static_cast<int>(std::lround(p.y * (1 << kShift)))};
}

void DrawLine(cv::Mat& picture, const cv::Point2d& a, const cv::Point2d& b, const cv::Scalar& colour, int width) {
  if (IsDrawable(a) && IsDrawable(b)) cv::line(picture, Fixed(a), Fixed(b), colour, width, cv::LINE_AA, kShift);
}

void DrawPath(cv::Mat& picture, const Projection& project, const std::vector<Eigen::Vector3d>& path,
              const cv::Scalar& colour, int width) {
  if (path.empty()) return;
  cv::Point2d last = project(path.front());
  for (size_t i = 1; i < path.size(); ++i) {
    const cv::Point2d px = project(path[i]);
    // Lines shorter than a pixel are most of the work and invisible.
    if (i + 1 < path.size() && cv::norm(px - last) < 1.0) continue;
    DrawLine(picture, last, px, colour, width);
    last = px;
  }
}

/// 1, 2 or 5 times a power of ten, about a quarter of the side.
double RoundLength(double side_m) {
  const double power = std::pow(10.0, std::floor(std::log10(side_m / 4.0)));
  const double share = side_m / 4.0 / power;
  return power * (share >= 5.0 ? 5.0 : share >= 2.0 ? 2.0 : 1.0);
}

void DrawScale(cv::Mat& picture, const Projection& project, double side_m) {
  const double length_m = RoundLength(side_m);
  const cv::Point2d left(14.0, picture.rows - 16.0);
  const cv::Point2d right = left + cv::Point2d(length_m * project.px_per_m(), 0.0);
  DrawLine(picture, left, right, kText, 2);
  cv::putText(picture, fmt::format("{:g} m", length_m), {14, picture.rows - 24}, cv::FONT_HERSHEY_SIMPLEX, 0.45,
              kText, 1, cv::LINE_AA);
}

}  // namespace

void TopViewWindow::Include(const std::vector<Eigen::Vector3d>& path) {
  for (const Eigen::Vector3d& p : path) {
    if (!p.allFinite()) continue;
    const Eigen::Vector2d ground(p.x(), p.z());
    path_low_ = empty_ ? ground : path_low_.cwiseMin(ground);
    path_high_ = empty_ ? ground : path_high_.cwiseMax(ground);
    if (empty_) low_ = high_ = ground;
    empty_ = false;
  }
  Grow(path_low_, path_high_);
}

void TopViewWindow::IncludeMiddle(const std::vector<Eigen::Vector3d>& points) {
  if (empty_) return;
  const double reach_m = std::max(kLeastReach_m, (path_high_ - path_low_).maxCoeff());
  Eigen::Vector2d low = path_low_, high = path_high_;
  for (const int axis : {0, 1}) {
    std::vector<double> values;
    for (const Eigen::Vector3d& p : points) {
      if (p.allFinite()) values.push_back(axis == 0 ? p.x() : p.z());
    }
    if (values.size() < kLeastPoints) return;
    const auto at = [&](double share) {
      const auto middle =
          values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
      std::nth_element(values.begin(), middle, values.end());
      return std::clamp(*middle, path_low_[axis] - reach_m, path_high_[axis] + reach_m);
    };
    low[axis] = at(kLowShare);
    high[axis] = at(kHighShare);
  }
  Grow(low, high);
}

void TopViewWindow::Grow(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  low_ = low_.cwiseMin(low);
  high_ = high_.cwiseMax(high);
  while (side_m_ < kMargin * (high_ - low_).maxCoeff() && side_m_ < 1e7) side_m_ *= kGrowth;
}

cv::Mat DrawTopView(const TopViewScene& scene, const TopViewWindow& window, const cv::Size& size) {
  cv::Mat picture(size, CV_8UC3, kGround);
  const Projection project(window, size);
  for (const Eigen::Vector3d& point : scene.points) {
    const cv::Point2d px = project(point);
    if (px.x >= 0.0 && px.y >= 0.0 && px.x < size.width && px.y < size.height) {
      picture.at<cv::Vec3b>(static_cast<int>(px.y), static_cast<int>(px.x)) = kPoint;
    }
  }
  for (const auto& [p, q] : scene.segments) DrawLine(picture, project(p), project(q), kSegment, 1);
  DrawPath(picture, project, scene.path, kPath, 2);
  if (!scene.path.empty() && IsDrawable(project(scene.path.back()))) {
    cv::circle(picture, Fixed(project(scene.path.back())), 5 << kShift, kCamera, -1, cv::LINE_AA, kShift);
  }
  DrawScale(picture, project, window.side_m());
  return picture;
}

}  // namespace plslam::viewer
