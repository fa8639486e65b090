#include "viewer_headless/overlay_queue.h"

#include <utility>

namespace plslam {
namespace {

constexpr size_t kMaxWaiting = 8;

}  // namespace

std::optional<OverlayQueue::Ready> OverlayQueue::AddImage(int64_t frame_id, const cv::Mat& image) {
  if (!Wants(frame_id) || image.empty()) return std::nullopt;
  waiting_[frame_id].image = image;
  return Take(frame_id);
}

std::optional<OverlayQueue::Ready> OverlayQueue::AddFeatures(int64_t frame_id, OverlayFeatures features) {
  if (!Wants(frame_id)) return std::nullopt;
  waiting_[frame_id].features = std::move(features);
  return Take(frame_id);
}

std::optional<OverlayQueue::Ready> OverlayQueue::AddCaption(int64_t frame_id, std::string caption) {
  if (!Wants(frame_id)) return std::nullopt;
  waiting_[frame_id].caption = std::move(caption);
  return Take(frame_id);
}

std::optional<OverlayQueue::Ready> OverlayQueue::Take(int64_t frame_id) {
  const auto found = waiting_.find(frame_id);
  Parts& parts = found->second;
  if (parts.image.empty() || !parts.features || !parts.caption) {
    if (waiting_.size() > kMaxWaiting) waiting_.erase(waiting_.begin());
    return std::nullopt;
  }
  Ready ready{frame_id, parts.image, std::move(*parts.features), std::move(*parts.caption)};
  waiting_.erase(found);
  return ready;
}

}  // namespace plslam
