// SPDX-License-Identifier: BSD-3-Clause
#include "camera/camera_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "camera/pipeline_text.h"

namespace plslam::camera {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTick{100};
constexpr milliseconds kFirstPause{200};
constexpr milliseconds kLongestPause{2000};
constexpr int64_t kUsualPeriod_ns = 50'000'000;
/// A source that is not live waits when this many pairs are queued.
constexpr size_t kEnoughWaiting = 2;

int64_t Nanoseconds(double ms) { return static_cast<int64_t>(1e6 * ms); }

}  // namespace

CameraSource::CameraSource(LiveRig live, bool resumes, Listener listener)
    : live_(std::move(live)),
      listener_(std::move(listener)),
      text_(PipelineText(live_)),
      utc_ns_(UtcOfGstClock_ns()),
      resumes_(resumes),
      pairing_(MakePairing()),
      health_(live_.rig.rate_hz),
      pause_(kFirstPause) {
  is_live_ = !MayEnd(live_.source.type);
  try {
    Build();
  } catch (const std::runtime_error& error) {
    // One that was killed together with its cable waits for it, as it would have done before.
    if (!resumes_ || live_.source.type == SourceSpec::Type::kFiles) throw std::runtime_error(Named(error.what()));
    outage_ = error.what();
  }
  pairing_ = MakePairing();
}

Pairing CameraSource::MakePairing() const { return Pairing(Nanoseconds(live_.source.max_skew_ms), is_live_); }

void CameraSource::Build() {
  playing_ = false;
  watch_.OnBuild();
  pipeline_ = std::make_unique<CameraPipeline>(text_, &wakeup_);
  is_live_ = pipeline_->is_live();
}

/// "rig.yaml: source.pair: WHAT".
std::string CameraSource::Named(const std::string& what) const {
  return fmt::format("{}: source.{}: {}", live_.path, KeyOf(live_.source.type), what);
}

int64_t CameraSource::period_ns() const {
  return live_.rig.rate_hz > 0.0 ? static_cast<int64_t>(1e9 / live_.rig.rate_hz) : kUsualPeriod_ns;
}

/// Files are played again from their beginning, and skipped up to the resume point: the position of an image in a file
/// cannot be computed.
int64_t CameraSource::Begin(const std::optional<stream::ResumePoint>& behind) {
  order_.OnBegin(behind ? std::optional(behind->t_ns) : std::nullopt);
  watch_.OnBegin(Clock::now());
  if (playing_ && !is_live_) {
    pipeline_.reset();
    pairing_ = MakePairing();
    health_ = CaptureHealth(live_.rig.rate_hz);
    Build();
  }
  if (pipeline_ && !playing_) Play();
  return 0;
}

void CameraSource::Play() {
  pipeline_->Play();
  playing_ = true;
  watch_.OnPlay(Clock::now());  // opening may have taken long
}

void CameraSource::Stop() {
  stopped_ = true;
  wakeup_.Call();
}

void CameraSource::CheckSize(Side side, const cv::Mat& pixels) const {
  const CameraCalibration& camera = side == Side::kLeft ? live_.rig.left : live_.rig.right;
  if (pixels.cols == camera.width_px && pixels.rows == camera.height_px) return;
  throw std::runtime_error(Named(fmt::format(
      "the {0} images have {1}x{2} pixels, but {0}.resolution_px is {3}x{4}: set the camera to the size at which it "
      "was calibrated",
      side == Side::kLeft ? "left" : "right", pixels.cols, pixels.rows, camera.width_px, camera.height_px)));
}

bool CameraSource::Take(Side side) {
  if (!is_live_ && pairing_.waiting(side) >= kEnoughWaiting) return false;
  std::optional<CapturedImage> image;
  try {
    image = pipeline_->Take(side);
  } catch (const std::runtime_error& error) {
    // A camera may give such an image now and then; one that gives no others falls silent.
    if (is_live_ && order_.has_frames()) return true;
    throw std::runtime_error(Named(error.what()));
  }
  if (!image) {
    return pipeline_->ended(side) && pairing_.End(side);
  }
  CheckSize(side, image->pixels);
  if (is_live_) image->t_ns += utc_ns_;
  watch_.OnImage(side, Clock::now());
  pairing_.Add(side, std::move(*image));
  return true;
}

bool CameraSource::IsOver() {
  const auto is_over = [this](Side side) { return pipeline_->ended(side) && pairing_.waiting(side) == 0; };
  return is_over(Side::kLeft) || is_over(Side::kRight);
}

void CameraSource::TakeImages() {
  if (!pipeline_) return BuildAgain();
  const bool left = Take(Side::kLeft), right = Take(Side::kRight);
  if (left || right) return;
  std::string failure = pipeline_->Failure();
  if (failure.empty() && is_live_) {
    failure = IsOver() ? "the stream has ended" : watch_.Silence(Clock::now(), std::chrono::nanoseconds(period_ns()));
  }
  if (!failure.empty()) return OnFailure(failure);
  ReportStall();
  wakeup_.WaitFor(kTick);
}

/// A stream that is not live may arrive over a network, and its pipeline cannot be rebuilt at the same position.
void CameraSource::ReportStall() {
  if (is_live_ || !outage_.empty() || !watch_.HasStalled(Clock::now())) return;
  outage_ = fmt::format("the stream has sent no images for {} s", ImageWatch::kStall.count());
  listener_.on_outage(outage_);
}

void CameraSource::OnFailure(const std::string& why) {
  if (!is_live_ || (!order_.has_frames() && !resumes_)) throw std::runtime_error(Named(why));
  outage_ = why;
  pairing_.Clear();
  health_.Interrupt();
  // Devices are let go before they are opened again.
  pipeline_.reset();
}

/// Tries once to rebuild the pipeline. Whether frames arrive is checked later.
void CameraSource::BuildAgain() {
  listener_.on_outage(outage_);
  const std::chrono::duration<double> silent = watch_.SinceFrame(Clock::now());
  if (silent.count() > live_.source.give_up_s) {
    throw std::runtime_error(
        Named(fmt::format("no frames for {:.0f} s (source.give_up_s = {}): {}; check cables and power of the cameras",
                          silent.count(), live_.source.give_up_s, outage_)));
  }
  const auto until = Clock::now() + pause_;
  while (!stopped_ && Clock::now() < until) wakeup_.WaitFor(kTick);
  if (stopped_) return;
  pause_ = std::min(2 * pause_, kLongestPause);
  try {
    Build();
    Play();
  } catch (const std::runtime_error& error) {
    outage_ = error.what();
  }
}

stream::LoadedFrame CameraSource::MakeFrame(CapturedPair pair) {
  health_.Add(pair);
  listener_.on_frame(health_, pairing_);
  order_.OnFrame(pair.left.t_ns);
  watch_.OnFrame(Clock::now());
  if (!outage_.empty()) listener_.on_outage("");
  outage_.clear();
  pause_ = kFirstPause;
  stream::LoadedFrame frame;
  frame.images.t_ns = pair.left.t_ns;
  frame.images.left = std::move(pair.left.pixels);
  frame.images.right = std::move(pair.right.pixels);
  return frame;
}

/// A source without a single frame is an error.
std::optional<stream::LoadedFrame> CameraSource::End() const {
  if (order_.has_frames() || order_.has_resumed()) return std::nullopt;
  if (!watch_.HaveBothSent()) {
    throw std::runtime_error(Named("the stream has ended without images of both cameras"));
  }
  throw std::runtime_error(Named(fmt::format(
      "the stream has ended without a pair: left and right images are further apart than source.max_skew_ms = {}",
      live_.source.max_skew_ms)));
}

std::optional<stream::LoadedFrame> CameraSource::Next() {
  watch_.OnRequest(Clock::now());
  while (!stopped_) {
    if (std::optional<CapturedPair> pair = pairing_.Pop()) {
      if (order_.IsNew(pair->left.t_ns, is_live_)) return MakeFrame(std::move(*pair));
      continue;
    }
    if (pipeline_ && MayEnd(live_.source.type) && IsOver()) {
      // A pipeline that fails ends its streams, too, after it has reported the failure.
      const std::string failure = pipeline_->Failure();
      if (failure.empty()) return End();
      OnFailure(failure);
    }
    TakeImages();
  }
  return std::nullopt;
}

}  // namespace plslam::camera
