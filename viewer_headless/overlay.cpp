// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/overlay.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "core/geometry/image_mask.h"

namespace plslam::viewer {
namespace {

constexpr int kShift = 4;
constexpr int kBarHeight_px = 44;
constexpr float kNearDisparity_px = 64.0F;
constexpr int kOldAge = 20;
constexpr float kDash_px = 6.0F;
const cv::Scalar kNoDepth(165, 165, 165);
const cv::Scalar kMoving(255, 255, 255);
const cv::Scalar kBar(32, 32, 32);
const cv::Scalar kText(235, 235, 235);

cv::Point Fixed(const cv::Point2f& p) {
  return {static_cast<int>(std::lround(p.x * (1 << kShift))), static_cast<int>(std::lround(p.y * (1 << kShift)))};
}

// Fixed-point drawing overflows far outside the image, where nothing is visible.
bool IsDrawable(const cv::Point2f& p) { return std::abs(p.x) < 20000.0F && std::abs(p.y) < 20000.0F; }

// From red (1) over yellow and green to blue (0), all bright enough on grey.
cv::Scalar Rainbow(float share) {
  const float hue = 4.0F * std::clamp(1.0F - share, 0.0F, 1.0F);
  const auto channel = [hue](float centre, float width) {
    return 255.0 * std::clamp(static_cast<double>(width - std::abs(hue - centre)), 0.0, 1.0);
  };
  return {channel(4.0F, 2.0F), channel(2.0F, 2.0F), channel(0.0F, 2.0F)};
}

// Young segments violet, old ones yellow-green: apart from the colours of points.
cv::Scalar AgeColour(int age) {
  const double share = std::clamp(static_cast<double>(age) / kOldAge, 0.0, 1.0);
  return {255.0 * (1.0 - share), 70.0 + 185.0 * share, 255.0 - 100.0 * share};
}

cv::Scalar DisparityColour(float disparity_px) {
  // Logarithmic, to show depth.
  return Rainbow(std::log2(1.0F + std::max(0.0F, disparity_px)) / std::log2(1.0F + kNearDisparity_px));
}

void DrawDashed(cv::Mat& picture, const cv::Point2f& p, const cv::Point2f& q, const cv::Scalar& colour) {
  const cv::Point2f along = q - p;
  const float length = std::hypot(along.x, along.y);
  for (float s = 0.0F; s < length; s += 2.0F * kDash_px) {
    const float end = std::min(s + kDash_px, length);
    cv::line(picture, Fixed(p + along * (s / length)), Fixed(p + along * (end / length)), colour, 1, cv::LINE_AA,
             kShift);
  }
}

void DrawSegment(const OverlaySegment& segment, cv::Mat& picture) {
  if (!IsDrawable(segment.p_px) || !IsDrawable(segment.q_px)) return;
  if (!segment.HasDepth()) {
    DrawDashed(picture, segment.p_px, segment.q_px, kNoDepth);
    return;
  }
  const cv::Scalar colour = segment.moving ? kMoving : AgeColour(segment.age);
  cv::line(picture, Fixed(segment.p_px), Fixed(segment.q_px), colour, segment.age > 0 ? 3 : 2, cv::LINE_AA, kShift);
}

void DrawPoint(const OverlayPoint& point, cv::Mat& picture) {
  if (!IsDrawable(point.px)) return;
  const cv::Scalar with_depth = point.moving ? kMoving : DisparityColour(point.disparity_px);
  const cv::Scalar colour = point.disparity_px < 0.0F ? kNoDepth : with_depth;
  const int radius = (point.age > 0 ? 7 : 4) << (kShift - 1);
  cv::circle(picture, Fixed(point.px), radius, colour, point.age > 0 ? 2 : 1, cv::LINE_AA, kShift);
}

void PutText(cv::Mat& picture, const std::string& text, const cv::Point& at) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, kText, 1, cv::LINE_AA);
}

void DrawKey(cv::Mat& picture, int y) {
  PutText(picture, "points: near", {8, y});
  for (int i = 0; i < 60; ++i) {
    cv::line(picture, {100 + i, y - 9}, {100 + i, y}, Rainbow(1.0F - static_cast<float>(i) / 59.0F));
  }
  PutText(picture, "far    lines: new", {166, y});
  for (int i = 0; i < 60; ++i) {
    cv::line(picture, {292 + i, y - 9}, {292 + i, y}, AgeColour(i * kOldAge / 59));
  }
  PutText(picture, "old    no depth", {358, y});
  DrawDashed(picture, {474.0F, static_cast<float>(y) - 4.0F}, {520.0F, static_cast<float>(y) - 4.0F}, kNoDepth);
  PutText(picture, "white: moves", {534, y});
}

}  // namespace

cv::Mat DrawOverlay(const cv::Mat& image, const OverlayFeatures& features, const std::string& caption,
                    const cv::Mat& mask) {
  CV_Assert(image.type() == CV_8UC1 && !image.empty());
  cv::Mat picture(image.rows + kBarHeight_px, image.cols, CV_8UC3, kBar);
  cv::Mat top = picture.rowRange(0, image.rows);
  cv::cvtColor(image, top, cv::COLOR_GRAY2BGR);
  ShadeMask(mask, top);
  for (const OverlaySegment& segment : features.segments) DrawSegment(segment, top);
  for (const OverlayPoint& point : features.points) DrawPoint(point, top);
  PutText(picture, caption, {8, image.rows + 17});
  DrawKey(picture, image.rows + 37);
  return picture;
}

namespace {

// In lockstep a part arrives late if its message had to be repaired, and no other part may be dropped meanwhile.
constexpr size_t kMaxWaiting = 1024;
constexpr size_t kMaxImageBytes = 64'000'000;

}  // namespace

void OverlayQueue::AddImage(FrameId frame_id, const cv::Mat& image, const cv::Mat& right) {
  if (!Wants(frame_id) || image.empty()) return;
  Parts& parts = waiting_[frame_id];
  image_bytes_ -= parts.image_bytes();
  parts.image = image;
  parts.right = right;
  image_bytes_ += parts.image_bytes();
  first_image_ = std::min(first_image_.value_or(frame_id), frame_id);
  Took(frame_id);
}

void OverlayQueue::AddFeatures(FrameId frame_id, OverlayFeatures features) {
  if (!Wants(frame_id)) return;
  waiting_[frame_id].features = std::move(features);
  Took(frame_id);
}

void OverlayQueue::AddPose(const FramePose& pose) {
  if (!Wants(pose.frame_id)) return;
  waiting_[pose.frame_id].pose = pose;
  lacking_.insert(pose.frame_id);
  Took(pose.frame_id);
}

void OverlayQueue::Took(FrameId frame_id) {
  const Parts& parts = waiting_[frame_id];
  if (parts.pose && parts.features && !parts.image.empty()) complete_.insert(frame_id);
  if (waiting_.size() > kMaxWaiting) Drop(waiting_.begin());
  while (image_bytes_ > kMaxImageBytes && waiting_.size() > 1) {
    Drop(std::find_if(waiting_.begin(), waiting_.end(),
                      [](const auto& entry) { return !entry.second.image.empty(); }));
  }
}

void OverlayQueue::Drop(std::map<FrameId, Parts>::iterator parts) {
  image_bytes_ -= parts->second.image_bytes();
  complete_.erase(parts->first);
  waiting_.erase(parts);
}

std::optional<OverlayQueue::Ready> OverlayQueue::Next() {
  if (complete_.empty()) return std::nullopt;
  const auto found = waiting_.find(*complete_.begin());
  Parts& parts = found->second;
  Ready ready{std::move(*parts.pose), parts.image, parts.right, std::move(*parts.features)};
  lacking_.erase(found->first);
  Drop(found);
  return ready;
}

}  // namespace plslam::viewer
