#include "viewer_headless/node/picture_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <exception>

#include "core/io/images/png_file.h"
#include "plslam/tracks_t.hpp"
#include "viewer_headless/node/message_values.h"
#include "viewer_headless/progress.h"

namespace plslam {
namespace {

constexpr size_t kMaxWaiting = 16;
constexpr int kOverlayCompression = 3;

/// A picture of every so many-th frame is wanted by somebody; keyframes, which the report wants, can be any.
int64_t Every(const ViewerOptions& options, const PictureStore* store) {
  const bool all = !options.video.empty() || (store != nullptr && options.report_pictures > 0);
  return all ? 1 : options.overlay_every;
}

}  // namespace

PictureNode::PictureNode(bus::Bus& bus, const ViewerOptions& options, Sources sources, std::function<void()> rejected)
    : options_(options), sources_(sources), rejected_(std::move(rejected)), queue_(Every(options, sources.store)) {
  BeginAgain(sources.store);
  const int64_t every = Every(options, sources.store);
  if (every == 0) return;
  bus.Subscribe<tracks_t>(bus::kTracks, [this](const tracks_t& m) {
    if (queue_.Wants(m.frame_id)) Use(queue_.AddFeatures(m.frame_id, ToOverlayFeatures(m)));
  });
  frames_ = std::make_unique<bus::FrameSubscriber>(
      bus, bus::FrameSubscriber::Mode::kBestEffort, [this](const auto& frame) { OnFrame(frame); },
      // Called on the receiving thread: looks at nothing that changes.
      [every](int64_t frame_id) { return OverlayQueue(every).Wants(frame_id); });
}

void PictureNode::BeginAgain(PictureStore* store) {
  sources_.store = store;
  film_.reset();
  if (!options_.video.empty()) film_ = std::make_unique<Film>(options_.video);
  if (film_) film_->SetRate(rate_hz_);
  queue_ = OverlayQueue(Every(options_, store));
  poses_.clear();
}

void PictureNode::SetRectifier(const Rectifier* rectifier, double rate_hz) {
  rectifier_ = rectifier;
  rate_hz_ = rate_hz;
  if (film_) film_->SetRate(rate_hz_);
}

void PictureNode::AddPose(const FramePose& pose) {
  if (!queue_.Wants(pose.frame_id)) return;
  poses_.insert_or_assign(pose.frame_id, pose);
  if (poses_.size() > kMaxWaiting) poses_.erase(poses_.begin());
  Use(queue_.AddCaption(pose.frame_id, FrameCaption(pose)));
}

void PictureNode::OnFrame(const bus::FrameSubscriber::Frame& frame) {
  if (rectifier_ != nullptr) Use(queue_.AddImage(frame.images.frame_id, frame.images.left));
}

void PictureNode::Use(const std::optional<OverlayQueue::Ready>& ready) {
  if (!ready || rectifier_ == nullptr) return;
  const auto pose = poses_.find(ready->frame_id);
  const bool drawn = film_ || (options_.overlay_every > 0 && ready->frame_id % options_.overlay_every == 0);
  PictureStore* const store = sources_.store;
  const bool keyframe = store != nullptr && pose != poses_.end() && pose->second.keyframe_id >= 0;
  const bool stored = store != nullptr && store->Wants(ready->frame_id);
  if (!drawn && !keyframe && !stored) return;
  try {
    const cv::Mat image = rectifier_->RectifyLeft(ready->image);
    if (stored) store->Add(ready->frame_id, image, ready->features);
    if (keyframe) store->AddKeyframe(ready->frame_id, image);
    if (!drawn) return;
    const cv::Mat picture = DrawOverlay(image, ready->features, ready->caption);
    if (options_.overlay_every > 0 && ready->frame_id % options_.overlay_every == 0)
      WriteOverlay(ready->frame_id, picture);
    if (film_ && pose != poses_.end() && sources_.map != nullptr) film_->Add(pose->second, picture, *sources_.map);
  } catch (const std::exception& e) {
    spdlog::warn("frame {}: {}", ready->frame_id, e.what());
    rejected_();
  }
}

void PictureNode::WriteOverlay(int64_t frame_id, const cv::Mat& picture) const {
  WritePng(fmt::format("{}/overlays/{:06}.png", options_.out, frame_id), picture, kOverlayCompression);
}

}  // namespace plslam
