// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_headless/node/picture_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/errors/log.h"
#include "core/io/images/png_codec.h"
#include "plslam/tracks_t.hpp"
#include "viewer_headless/captions.h"
#include "viewer_headless/node/message_values.h"

namespace plslam::viewer {
namespace {

constexpr int kOverlayCompression = 3;
constexpr const char* kNotHeard = "their images or features were not received by viewer_headless";

/// Returns n if pictures of every n-th frame are needed; the keyframes for the report can be any frames.
int64_t Every(const ViewerOptions& options, const PictureStore* store) {
  const bool all = !options.video.empty() || (store != nullptr && options.report_pictures > 0);
  return all ? 1 : options.overlay_every;
}

}  // namespace

PictureNode::PictureNode(bus::Bus& bus, const ViewerOptions& options, Sources sources, std::function<void()> rejected,
                         std::function<void()> came)
    : options_(options),
      sources_(sources),
      rejected_(std::move(rejected)),
      came_(std::move(came)),
      queue_(Every(options, sources.store)) {
  StartNewRun(sources.store);
  const int64_t every = Every(options, sources.store);
  if (every == 0) return;
  const auto on_tracks = [this](const tracks_t& m) {
    if (queue_.Wants(FrameId(m.frame_id))) queue_.AddFeatures(FrameId(m.frame_id), ToOverlayFeatures(m));
    UseAll();
  };
  bus.Subscribe<tracks_t>(bus::kTracks, on_tracks);
  bus.Subscribe<tracks_t>(bus::kTracksLive, on_tracks);
  frames_ = std::make_unique<bus::FrameSubscriber>(
      bus, bus::FrameSubscriber::Mode::kPictures, [this](const auto& frame) { OnFrame(frame); },
      // Called on the receiving thread: must not access mutable state.
      [every](FrameId frame_id) { return OverlayQueue(every).Wants(frame_id); });
}

void PictureNode::StartNewRun(PictureStore* store) {
  sources_.store = store;
  film_.reset();
  film_problem_.reset();
  film_note_.clear();
  if (!options_.video.empty() && sources_.map != nullptr) film_ = std::make_unique<Film>(options_.video);
  if (film_ && camera_) film_->SetRate(camera_->rig.rate_hz);
  queue_ = OverlayQueue(Every(options_, store));
  n_pictures_ = 0;
  newest_ = -1;
  problem_.clear();
}

void PictureNode::SetCamera(const RigCalibration& rig, const Rectification& rectification) {
  camera_.emplace(Camera{rig, rectification.camera.width_px,
                         SmallRectifier(rectification, rectification.left, "left", PictureStore::kPictureWidth_px),
                         SmallRectifier(rectification, rectification.right, "right", PictureStore::kRightWidth_px),
                         std::nullopt});
  if (film_) film_->SetRate(rig.rate_hz);
  UseAll();
}

void PictureNode::AddPose(const FramePose& pose) {
  queue_.AddPose(pose);
  UseAll();
}

void PictureNode::OnFrame(const bus::FrameSubscriber::Frame& frame) {
  const StereoImages& images = frame.images;
  // A depth map is no picture.
  const bool has_right = images.right.type() == CV_8UC1 && IsStored(images.frame_id);
  queue_.AddImage(images.frame_id, images.left, has_right ? images.right : cv::Mat());
  UseAll();
}

/// Pictures wait for the camera, too.
void PictureNode::UseAll() {
  while (camera_) {
    const std::optional<OverlayQueue::Ready> ready = queue_.Next();
    if (!ready) return;
    Use(*ready);
    came_();
  }
}

void PictureNode::Use(const OverlayQueue::Ready& ready) {
  const FrameId frame_id = ready.pose.frame_id;
  ++n_pictures_;
  newest_ = std::max(newest_, frame_id);
  const bool drawn = film_ || IsOverlay(frame_id);
  try {
    Store(ready);
    if (!drawn) return;
    const cv::Mat picture = Draw(ready);
    if (film_) film_->Add(ready.pose, picture, *sources_.map);
    if (IsOverlay(frame_id)) WriteOverlay(frame_id, picture);
  } catch (const std::exception& e) {
    LogWarning("frame {}: {}", frame_id, e.what());
    if (problem_.empty()) problem_ = e.what();
    rejected_();
  }
}

/// Stores the pictures of a frame that the report needs.
void PictureNode::Store(const OverlayQueue::Ready& ready) {
  PictureStore* const store = sources_.store;
  const FrameId frame_id = ready.pose.frame_id;
  const bool keyframe = store != nullptr && ready.pose.keyframe_id >= 0;
  const bool stored = IsStored(frame_id);
  if (!keyframe && !stored) return;
  const cv::Mat left = camera_->left.Apply(ready.image);
  if (stored) {
    const cv::Mat right = ready.right.empty() ? cv::Mat() : camera_->right.Apply(ready.right);
    store->Add(frame_id, left, right, ready.features, camera_->width_px);
  }
  if (keyframe) store->AddKeyframe(frame_id, left);
}

cv::Mat PictureNode::Draw(const OverlayQueue::Ready& ready) {
  if (!camera_->whole) camera_->whole.emplace(camera_->rig);
  const Rectifier& rectifier = *camera_->whole;
  return DrawOverlay(rectifier.RectifyLeft(ready.image), ready.features, FrameCaption(ready.pose),
                     rectifier.left_mask());
}

bool PictureNode::IsOverlay(FrameId frame_id) const {
  return options_.overlay_every > 0 && frame_id.value % options_.overlay_every == 0;
}

bool PictureNode::IsStored(FrameId frame_id) const {
  return sources_.store != nullptr && sources_.store->Wants(frame_id);
}

std::string PictureNode::OverlayFile(FrameId frame_id) const {
  return fmt::format("{}/overlays/{:06}.png", options_.out, frame_id);
}

void PictureNode::WriteOverlay(FrameId frame_id, const cv::Mat& picture) {
  WritePng(OverlayFile(frame_id), picture, kOverlayCompression);
}

bool PictureNode::MayCome() const {
  const auto& lacking = queue_.lacking();
  return queue_.first_image() ? lacking.lower_bound(*queue_.first_image()) != lacking.end() : !lacking.empty();
}

PictureNode::Result PictureNode::Finish(const Recorder& recorder, bool lockstep, bool ended) {
  const FrameId last = ended ? FrameId(std::numeric_limits<int64_t>::max()) : newest_;
  Result result;
  int64_t lacking = 0, of_report = 0;
  for (const FrameId frame_id : queue_.lacking()) {
    if (frame_id > last) break;
    ++lacking;
    const bool stored = IsStored(frame_id);
    of_report += stored ? 1 : 0;
    const bool overlay = IsOverlay(frame_id) && !std::filesystem::exists(OverlayFile(frame_id));
    result.missing += stored || overlay || !options_.video.empty() ? 1 : 0;
  }
  if (sources_.store != nullptr) sources_.store->SetMissing(of_report);
  if (result.missing > 0) LogWarning("pictures of {} frames are missing: {}", result.missing, Why());
  for (const std::string& failure : {LackOfOverlays(recorder, lockstep, last), LackOfFilm(lockstep, lacking)}) {
    if (!failure.empty()) result.failures.push_back(failure);
  }
  result.film_note = film_note_;
  return result;
}

std::string PictureNode::Why() const { return problem_.empty() ? kNotHeard : problem_; }

std::string PictureNode::LackOfOverlays(const Recorder& recorder, bool lockstep, FrameId last) const {
  if (options_.overlay_every == 0 || (!lockstep && problem_.empty())) return "";
  int64_t asked = 0, missing = 0;
  for (const auto& [frame_id, frame] : recorder.frames()) {
    if (FrameId(frame_id) > last || !IsOverlay(FrameId(frame_id))) continue;
    ++asked;
    missing += std::filesystem::exists(OverlayFile(FrameId(frame_id))) ? 0 : 1;
  }
  if (missing == 0) return "";
  return fmt::format("{} of {} pictures are missing in {}/overlays: {}", missing, asked, options_.out, Why());
}

/// An incomplete film counts as none.
std::string PictureNode::LackOfFilm(bool lockstep, int64_t missing) {
  if (!film_) return film_problem_.value_or("");
  film_problem_.emplace();
  if (lockstep && missing > 0) {
    film_problem_ = fmt::format("{}: no film: {} of {} frames have no picture: {}", options_.video, missing,
                                n_pictures_ + missing, Why());
  } else if (n_pictures_ + missing > 0) {
    try {
      film_->Finish();
      film_note_ = film_->note();
    } catch (const std::exception& e) {
      film_problem_ = e.what();
    }
  }
  film_.reset();
  return *film_problem_;
}

}  // namespace plslam::viewer
