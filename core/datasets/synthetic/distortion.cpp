// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/distortion.h"

#include <algorithm>
#include <cmath>

namespace plslam::synthetic {
namespace {

constexpr double kFiner = 1.5;  // pixels of the ideal image for one of the recorded one, along each side

struct Point {
  double x = 0.0;
  double y = 0.0;
};

Point Distort(const Point& p, const std::array<double, 4>& k) {
  const double r2 = p.x * p.x + p.y * p.y;
  const double radial = 1.0 + r2 * (k[0] + r2 * k[1]);
  return {p.x * radial + 2.0 * k[2] * p.x * p.y + k[3] * (r2 + 2.0 * p.x * p.x),
          p.y * radial + k[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * k[3] * p.x * p.y};
}

/// Fixed-point iteration; contracts for the mild lenses used here.
Point Undistort(const Point& distorted, const std::array<double, 4>& k) {
  Point p = distorted;
  for (int i = 0; i < 60; ++i) {
    const Point at = Distort(p, k);
    p.x += distorted.x - at.x;
    p.y += distorted.y - at.y;
  }
  return p;
}

}  // namespace

Lens::Lens(const Intrinsics& intrinsics, const std::array<double, 4>& k) : recorded_(intrinsics), k_(k) {
  const int width = intrinsics.width;
  const int height = intrinsics.height;
  std::vector<Point> rays;
  Point low{1e9, 1e9};
  Point high{-1e9, -1e9};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Point ray = Undistort({(x - intrinsics.cx) / intrinsics.fx, (y - intrinsics.cy) / intrinsics.fy}, k);
      low = {std::min(low.x, ray.x), std::min(low.y, ray.y)};
      high = {std::max(high.x, ray.x), std::max(high.y, ray.y)};
      rays.push_back(ray);
    }
  }
  ideal_.fx = intrinsics.fx * kFiner;
  ideal_.fy = intrinsics.fy * kFiner;
  ideal_.cx = 2.0 - low.x * ideal_.fx;
  ideal_.cy = 2.0 - low.y * ideal_.fy;
  ideal_.width = static_cast<int>(std::ceil((high.x - low.x) * ideal_.fx)) + 5;
  ideal_.height = static_cast<int>(std::ceil((high.y - low.y) * ideal_.fy)) + 5;
  for (const Point& ray : rays) {
    map_.push_back(
        {static_cast<float>(ray.x * ideal_.fx + ideal_.cx), static_cast<float>(ray.y * ideal_.fy + ideal_.cy)});
  }
}

std::vector<float> Lens::Apply(const std::vector<float>& ideal) const {
  // The mean of four bilinear taps half an ideal pixel off is the box of a recorded pixel, symmetric about its
  // centre.
  std::vector<float> out(map_.size());
  const auto fetch = [this, &ideal](float x, float y) {
    const int x0 = static_cast<int>(x);
    const int y0 = static_cast<int>(y);
    const float fx = x - static_cast<float>(x0);
    const float fy = y - static_cast<float>(y0);
    const float* top = &ideal[static_cast<size_t>(y0) * ideal_.width + x0];
    const float* bottom = top + ideal_.width;
    const float a = top[0] + fx * (top[1] - top[0]);
    const float b = bottom[0] + fx * (bottom[1] - bottom[0]);
    return a + fy * (b - a);
  };
  for (size_t i = 0; i < map_.size(); ++i) {
    const Source& at = map_[i];
    const float above = fetch(at.x - 0.5F, at.y - 0.5F) + fetch(at.x + 0.5F, at.y - 0.5F);
    const float below = fetch(at.x - 0.5F, at.y + 0.5F) + fetch(at.x + 0.5F, at.y + 0.5F);
    out[i] = 0.25F * (above + below);
  }
  return out;
}

double DisparityBias::At(double u_px) const {
  const double t = (u_px - 0.5 * (width_ - 1)) / (width_ / 3.0);
  const auto [a, b, c] = thirds_px_;
  return b + t * (0.5 * (c - a) + t * (0.5 * (a + c) - b));
}

std::vector<float> DisparityBias::Apply(const std::vector<float>& right, const std::vector<float>& depth_m,
                                        double focal_baseline) const {
  std::vector<float> out(right.size());
  for (size_t i = 0; i < right.size(); ++i) {
    const int x = static_cast<int>(i % width_);
    const double disparity_px = depth_m[i] > 0.0F ? focal_baseline / depth_m[i] : 0.0;
    const double from = std::clamp(x + At(x + disparity_px), 1.0, width_ - 3.0);
    // Catmull and Rom's cubic: hardly less sharp than its input.
    const int x0 = static_cast<int>(from);
    const auto t = static_cast<float>(from - x0);
    const float* p = &right[i - x + x0];
    out[i] = p[0] +
             0.5F * t *
                 (p[1] - p[-1] +
                  t * (2.0F * p[-1] - 5.0F * p[0] + 4.0F * p[1] - p[2] + t * (3.0F * (p[0] - p[1]) + p[2] - p[-1])));
  }
  return out;
}

}  // namespace plslam::synthetic
