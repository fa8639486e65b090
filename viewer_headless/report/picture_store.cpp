// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/report/picture_store.h"

#include <algorithm>
#include <utility>

#include "core/io/images/jpeg_codec.h"
#include "viewer_headless/report/small_images.h"

namespace plslam::viewer {
namespace {

constexpr int kKeyframeWidth_px = 320;
constexpr int kQuality = 68;

OverlayFeatures Scale(const OverlayFeatures& features, float scale) {
  // Disparities are not scaled: they represent depth.
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

void PictureStore::Add(FrameId frame_id, const cv::Mat& left, const cv::Mat& right, const OverlayFeatures& features,
                       int width_px) {
  const cv::Mat small = Shrink(left, kPictureWidth_px);
  const float scale = static_cast<float>(small.cols) / static_cast<float>(width_px);
  ReportPicture picture{frame_id, small.cols, small.rows, EncodeJpeg(small, kQuality), {}, Scale(features, scale)};
  if (!right.empty()) picture.right_jpeg = EncodeJpeg(Shrink(right, kRightWidth_px), kQuality);
  pictures_.insert_or_assign(frame_id, std::move(picture));
  while (static_cast<int64_t>(pictures_.size()) > max_pictures_) {
    stride_ *= 2;
    std::erase_if(pictures_, [this](const auto& entry) { return !Wants(entry.first); });
  }
}

void PictureStore::AddKeyframe(FrameId frame_id, const cv::Mat& image) {
  keyframes_.insert_or_assign(frame_id, EncodeJpeg(Shrink(image, kKeyframeWidth_px), kQuality));
  if (keyframes_.size() <= kMaxKeyframes) return;
  bool drop = false;
  std::erase_if(keyframes_, [&drop](const auto&) { return std::exchange(drop, !drop); });
}

std::string PictureStore::Keyframe(FrameId frame_id) const {
  const auto found = keyframes_.find(frame_id);
  return found == keyframes_.end() ? std::string() : found->second;
}

}  // namespace plslam::viewer
