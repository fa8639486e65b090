// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/overlay_queue.h"

#include <algorithm>
#include <utility>

namespace plslam {
namespace {

// In lockstep a part comes late where its message had to be repaired, and nothing else may be dropped meanwhile.
constexpr size_t kMaxWaiting = 1024;
constexpr size_t kMaxImageBytes = 64'000'000;

}  // namespace

void OverlayQueue::AddImage(int64_t frame_id, const cv::Mat& image, const cv::Mat& right) {
  if (!Wants(frame_id) || image.empty()) return;
  Parts& parts = waiting_[frame_id];
  image_bytes_ -= parts.image_bytes();
  parts.image = image;
  parts.right = right;
  image_bytes_ += parts.image_bytes();
  first_image_ = std::min(first_image_.value_or(frame_id), frame_id);
  Took(frame_id);
}

void OverlayQueue::AddFeatures(int64_t frame_id, OverlayFeatures features) {
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

void OverlayQueue::Took(int64_t frame_id) {
  const Parts& parts = waiting_[frame_id];
  if (parts.pose && parts.features && !parts.image.empty()) complete_.insert(frame_id);
  if (waiting_.size() > kMaxWaiting) Drop(waiting_.begin());
  while (image_bytes_ > kMaxImageBytes && waiting_.size() > 1) {
    Drop(std::find_if(waiting_.begin(), waiting_.end(),
                      [](const auto& entry) { return !entry.second.image.empty(); }));
  }
}

void OverlayQueue::Drop(std::map<int64_t, Parts>::iterator parts) {
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

}  // namespace plslam
