// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/picture_store.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/io/images/jpeg_codec.h"

namespace plslam::viewer {
namespace {

constexpr int kPictureWidth_px = 512;
/// Looked at now and then: at half the width it makes the report a third larger.
constexpr int kRightWidth_px = kPictureWidth_px / 2;
constexpr int kKeyframeWidth_px = 320;
constexpr int kQuality = 68;

// Means of whole blocks as far as they go (a border narrower than a block is cut off), and the rest between pixels: a
// tenth of the time that means over parts of pixels take.
cv::Mat Shrink(const cv::Mat& image, int width_px) {
  if (image.cols <= width_px) return image;
  const int height_px = std::max(1, image.rows * width_px / image.cols);
  const int block = std::min(image.cols / width_px, image.rows);
  const cv::Size blocks(image.cols / block, image.rows / block);
  cv::Mat means = image;
  if (block > 1)
    cv::resize(image({0, 0, blocks.width * block, blocks.height * block}), means, blocks, 0, 0, cv::INTER_AREA);
  cv::Mat small;
  cv::resize(means, small, {width_px, height_px}, 0, 0, cv::INTER_LINEAR);
  return small;
}

OverlayFeatures Scale(const OverlayFeatures& features, float scale) {
  // Disparities stay: they stand for depth.
  OverlayFeatures scaled = features;
  for (OverlayPoint& point : scaled.points) point.px *= scale;
  for (OverlaySegment& segment : scaled.segments) {
    segment.p_px *= scale;
    segment.q_px *= scale;
  }
  return scaled;
}

}  // namespace

void PictureStore::Announce(int64_t n_frames) {
  while (max_pictures_ > 0 && n_frames / stride_ > max_pictures_) stride_ *= 2;
}

void PictureStore::Add(int64_t frame_id, const cv::Mat& left, const cv::Mat& right, const OverlayFeatures& features) {
  const cv::Mat small = Shrink(left, kPictureWidth_px);
  const float scale = static_cast<float>(small.cols) / static_cast<float>(left.cols);
  ReportPicture picture{frame_id, small.cols, small.rows, EncodeJpeg(small, kQuality), {}, Scale(features, scale)};
  if (!right.empty()) picture.right_jpeg = EncodeJpeg(Shrink(right, kRightWidth_px), kQuality);
  pictures_.insert_or_assign(frame_id, std::move(picture));
  while (static_cast<int64_t>(pictures_.size()) > max_pictures_) {
    stride_ *= 2;
    std::erase_if(pictures_, [this](const auto& entry) { return !Wants(entry.first); });
  }
}

void PictureStore::AddKeyframe(int64_t frame_id, const cv::Mat& image) {
  keyframes_.insert_or_assign(frame_id, EncodeJpeg(Shrink(image, kKeyframeWidth_px), kQuality));
  if (keyframes_.size() <= kMaxKeyframes) return;
  bool drop = false;
  std::erase_if(keyframes_, [&drop](const auto&) { return std::exchange(drop, !drop); });
}

std::string PictureStore::Keyframe(int64_t frame_id) const {
  const auto found = keyframes_.find(frame_id);
  return found == keyframes_.end() ? std::string() : found->second;
}

}  // namespace plslam::viewer
