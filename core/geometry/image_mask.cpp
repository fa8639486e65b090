// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/image_mask.h"

#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace plslam {
namespace {

constexpr double kTolerance_px = 0.5;
/// Corners are drawn at a resolution of 1/256 px.
constexpr int kShift = 8;
/// A colour not used for features, in overlays or in the picture of rectification; a share of a third is visible over
/// dark and bright pixels.
const cv::Scalar kShade(170, 40, 170);
constexpr double kShadeShare = 0.35;

cv::Point Fixed(const Eigen::Vector2f& px) {
  constexpr double kUnits = 1 << kShift;
  return {static_cast<int>(std::lround(px.x() * kUnits)), static_cast<int>(std::lround(px.y() * kUnits))};
}

void Draw(const MaskPolygon& polygon, cv::Mat& image) {
  if (polygon.corners_px.empty()) return;
  std::vector<std::vector<cv::Point>> outline(1);
  for (const Eigen::Vector2f& px : polygon.corners_px) outline[0].push_back(Fixed(px));
  cv::fillPoly(image, outline, cv::Scalar(polygon.in_use ? 255 : 0), cv::LINE_8, kShift);
}

/// Outer contours of the non-zero pixels of `area`.
std::vector<std::vector<cv::Point>> Outlines(const cv::Mat& area) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(area, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  return outlines;
}

}  // namespace

cv::Mat DrawMask(const CameraCalibration& camera) {
  if (camera.mask.empty()) return {};
  cv::Mat image(camera.height_px, camera.width_px, CV_8UC1, cv::Scalar(255));
  for (const MaskPolygon& polygon : camera.mask) Draw(polygon, image);
  return image;
}

std::vector<MaskPolygon> TraceMask(const cv::Mat& image) {
  CV_Assert(image.type() == CV_8UC1);
  std::vector<MaskPolygon> polygons;
  // Alternates between masked regions, holes in them, masked regions in the holes, and so on, each filled without its
  // holes.
  cv::Mat area = image == 0;
  for (bool in_use = false; cv::countNonZero(area) > 0; in_use = !in_use) {
    const std::vector<std::vector<cv::Point>> outlines = Outlines(area);
    cv::Mat filled(image.size(), CV_8UC1, cv::Scalar(0));
    cv::fillPoly(filled, outlines, cv::Scalar(255));
    for (const std::vector<cv::Point>& outline : outlines) {
      std::vector<cv::Point> corners;
      cv::approxPolyDP(outline, corners, kTolerance_px, true);
      MaskPolygon polygon;
      polygon.in_use = in_use;
      for (const cv::Point& corner : corners) polygon.corners_px.emplace_back(corner.x, corner.y);
      polygons.push_back(std::move(polygon));
    }
    area = filled & ~area;
  }
  return polygons;
}

std::string MaskComplaint(const CameraCalibration& camera) {
  size_t n_corners = 0;
  for (const MaskPolygon& polygon : camera.mask) {
    n_corners += polygon.corners_px.size();
    for (const Eigen::Vector2f& px : polygon.corners_px) {
      const auto inside = [](double value, int size_px) { return value >= -size_px && value <= 2.0 * size_px; };
      if (inside(px.x(), camera.width_px) && inside(px.y(), camera.height_px)) continue;
      return fmt::format("corner [{}, {}] is not within {} to {} and {} to {} pixels", px.x(), px.y(),
                         -camera.width_px, 2 * camera.width_px, -camera.height_px, 2 * camera.height_px);
    }
  }
  if (n_corners > kMaxMaskCorners) {
    return fmt::format("the polygons of the mask have {} corners, at most {} are possible: draw them coarser",
                       n_corners, kMaxMaskCorners);
  }
  if (camera.mask.empty() || cv::countNonZero(DrawMask(camera)) > 0) return "";
  return "no pixel is in use; in a mask image 0 (black) is excluded, and all other values are in use";
}

void ShadeMask(const cv::Mat& mask, cv::Mat& picture) {
  if (mask.empty()) return;
  cv::Mat shaded;
  cv::addWeighted(picture, 1.0 - kShadeShare, cv::Mat(picture.size(), CV_8UC3, kShade), kShadeShare, 0.0, shaded);
  shaded.copyTo(picture, mask == 0);
}

}  // namespace plslam
