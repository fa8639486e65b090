// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectify_check/rectify_picture.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/geometry/image_mask.h"

namespace plslam::rectify_check {
namespace {

constexpr int kGap = 6;
constexpr int kEpipolarLines = 20;
/// Matches that are joined across the images; all of them would hide the pictures.
constexpr int kJoined = 40;
const cv::Scalar kLineColour(255, 200, 60);

cv::Scalar ColourOf(double row_error_px) {
  const double size = std::abs(row_error_px);
  if (size <= 1.0) return {80, 220, 80};
  return size <= 2.0 ? cv::Scalar(0, 165, 255) : cv::Scalar(60, 60, 255);
}

cv::Point At(const Eigen::Vector2d& px, int offset_x) {
  return {static_cast<int>(std::lround(px.x())) + offset_x, static_cast<int>(std::lround(px.y()))};
}

cv::Mat SideBySide(const MaskedImage& left, const MaskedImage& right, int caption_px) {
  cv::Mat picture(std::max(left.pixels.rows, right.pixels.rows) + caption_px,
                  left.pixels.cols + kGap + right.pixels.cols, CV_8UC3, cv::Scalar(40, 40, 40));
  int x = 0;
  for (const MaskedImage& image : {left, right}) {
    cv::Mat part = picture(cv::Rect(x, 0, image.pixels.cols, image.pixels.rows));
    cv::cvtColor(image.pixels, part, cv::COLOR_GRAY2BGR);
    ShadeMask(image.mask, part);
    x += image.pixels.cols + kGap;
  }
  return picture;
}

/// `kJoined` of them, evenly from top to bottom.
std::vector<RowMatch> EvenlyByRow(std::vector<RowMatch> matches) {
  std::stable_sort(matches.begin(), matches.end(),
                   [](const RowMatch& a, const RowMatch& b) { return a.left_px.y() < b.left_px.y(); });
  std::vector<RowMatch> chosen;
  const size_t n = std::min<size_t>(matches.size(), kJoined);
  for (size_t i = 0; i < n; ++i) chosen.push_back(matches[i * matches.size() / n]);
  return chosen;
}

}  // namespace

cv::Mat DrawRectification(const MaskedImage& left, const MaskedImage& right, const std::vector<RowMatch>& matches,
                          const std::string& caption) {
  const cv::Size size = left.pixels.size();
  const double font = std::clamp(size.width / 900.0, 0.45, 1.2);
  const int caption_px = static_cast<int>(34.0 * font + 12.0);
  cv::Mat picture = SideBySide(left, right, caption_px);
  for (int i = 0; i < kEpipolarLines; ++i) {
    const int y = (2 * i + 1) * size.height / (2 * kEpipolarLines);
    cv::line(picture, {0, y}, {picture.cols - 1, y}, kLineColour, 1);
  }
  const int offset = size.width + kGap;
  for (const RowMatch& m : EvenlyByRow(matches)) {
    cv::line(picture, At(m.left_px, 0), At(m.right_px, offset), ColourOf(m.RowError()), 1, cv::LINE_AA);
  }
  for (const RowMatch& m : matches) {
    for (const cv::Point& place : {At(m.left_px, 0), At(m.right_px, offset)}) {
      cv::circle(picture, place, 3, ColourOf(m.RowError()), 1, cv::LINE_AA);
    }
  }
  cv::putText(picture, caption, {8, picture.rows - caption_px / 3}, cv::FONT_HERSHEY_SIMPLEX, font, {235, 235, 235},
              1, cv::LINE_AA);
  return picture;
}

}  // namespace plslam::rectify_check
