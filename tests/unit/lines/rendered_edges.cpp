// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/lines/rendered_edges.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <Eigen/Geometry>

#include <opencv2/core.hpp>

namespace plslam::test {
namespace {

constexpr int kSub = 8;

using Grey = std::function<double(const Eigen::Vector2d&)>;

double Mean(const Grey& grey, const Eigen::Vector2d& middle) {
  double sum = 0.0;
  for (int i = 0; i < kSub * kSub; ++i) {
    const Eigen::Vector2d inside((i % kSub + 0.5) / kSub - 0.5, (i / kSub + 0.5) / kSub - 0.5);
    sum += grey(middle + inside);
  }
  return sum / (1.0 * kSub * kSub);
}

/// Pixels where `is_plain` holds, away from any border, are sampled once.
cv::Mat Render(cv::Size size, const Grey& grey, const std::function<bool(const Eigen::Vector2d&)>& is_plain) {
  cv::Mat image(size, CV_8UC1);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const Eigen::Vector2d at(x, y);
      image.at<uint8_t>(y, x) = cv::saturate_cast<uint8_t>(std::lround(is_plain(at) ? grey(at) : Mean(grey, at)));
    }
  }
  return image;
}

/// Returns the position of a point in a bar's frame: distance inside its ends, and inside its long sides; negative
/// outside.
Eigen::Vector2d Inside(const Bar& bar, const Eigen::Vector2d& at) {
  const Eigen::Vector2d step = bar.axis.q - bar.axis.p;
  const double length = step.norm();
  const Eigen::Vector2d d = step / length;
  const Eigen::Vector2d from_p = at - bar.axis.p;
  const double along = d.dot(from_p);
  const double across = d.x() * from_p.y() - d.y() * from_p.x();
  return {std::min(along, length - along), 0.5 * bar.width_px - std::abs(across)};
}

}  // namespace

cv::Mat RenderBars(cv::Size size, double ground, const std::vector<Bar>& bars) {
  const auto grey = [&](const Eigen::Vector2d& at) {
    for (const Bar& bar : bars) {
      if (Inside(bar, at).minCoeff() >= 0.0) return bar.grey;
    }
    return ground;
  };
  const auto is_plain = [&](const Eigen::Vector2d& at) {
    for (const Bar& bar : bars) {
      if (std::abs(Inside(bar, at).minCoeff()) < 1.0) return false;
    }
    return true;
  };
  return Render(size, grey, is_plain);
}

cv::Mat RenderEdge(cv::Size size, const Segment2& edge, double dark, double bright) {
  const Eigen::Vector3d line = LineThrough(edge);
  const auto side = [&](const Eigen::Vector2d& at) { return line.dot(at.homogeneous()); };
  return Render(
      size, [&](const Eigen::Vector2d& at) { return side(at) > 0.0 ? bright : dark; },
      [&](const Eigen::Vector2d& at) { return std::abs(side(at)) > 1.0; });
}

void AddNoise(cv::Mat& image, double sigma, uint32_t seed) {
  std::mt19937 random(seed);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      double sum = -6.0;
      for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
      uint8_t& v = image.at<uint8_t>(y, x);
      v = cv::saturate_cast<uint8_t>(std::lround(v + sigma * sum));
    }
  }
}

cv::Mat NoiseImage(cv::Size size, double mean, double sigma, uint32_t seed) {
  cv::Mat image(size, CV_8UC1, cv::Scalar(mean));
  AddNoise(image, sigma, seed);
  return image;
}

Segment2 TurnedSegment(cv::Size size, double angle_rad, double length_px, double offset_px) {
  const Eigen::Vector2d middle(0.5 * size.width, 0.5 * size.height);
  const Eigen::Vector2d d(std::cos(angle_rad), std::sin(angle_rad));
  const Eigen::Vector2d normal(-d.y(), d.x());
  return {middle + offset_px * normal - 0.5 * length_px * d, middle + offset_px * normal + 0.5 * length_px * d};
}

}  // namespace plslam::test
