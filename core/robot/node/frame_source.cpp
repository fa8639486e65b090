// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/node/frame_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_assembler.h"
#include "core/bus/run_loop.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/datasets/recordings/depth_images.h"
#include "core/datasets/recordings/topic_names.h"
#include "core/errors/log.h"
#include "core/files/dataset_error.h"
#include "core/geometry/body_frame.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "plslam/camera_t.hpp"
#include "plslam/intrinsics_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam::robot {
namespace {

/// Throws DatasetError if vo_process cannot use the rig.
void CheckRig(const RigCalibration& rig) {
  const std::string complaint = RigComplaint(rig);
  if (!complaint.empty()) throw DatasetError("describes an invalid rig: " + complaint);
  if (!bus::FrameAssembler::CanHold(rig.left.width_px, rig.left.height_px, 1)) {
    throw DatasetError(fmt::format("describes images of {}x{}, more than a message can hold", rig.left.width_px,
                                   rig.left.height_px));
  }
  AsDatasetError([&] { BodyFromCamera(rig); });
}

}  // namespace

FrameSource::FrameSource(bus::Process& process, Settings settings, Listener listener)
    : process_(process),
      settings_(std::move(settings)),
      listener_(std::move(listener)),
      publisher_(process.bus(), false),
      pairing_(settings_.max_skew_ns),
      imu_(process, settings_.imu) {
  if (settings_.camera.empty()) return;
  Notes notes;
  RigCalibration rig = ReadCalibration({settings_.camera}, {}, &notes);
  for (const std::string& warning : notes.warnings) LogWarning("{}", warning);
  for (const std::string& remark : notes.remarks) LogInfo("{}", remark);
  if ((rig.kind == RigCalibration::Kind::kRgbd) != is_rgbd()) {
    throw DatasetError(fmt::format(
        "{}: is for {}", settings_.camera,
        is_rgbd() ? fmt::format("a stereo camera, but {} has depths by its name (kind: rgbd)", settings_.right)
                  : "an RGB-D camera, but the right images are no depths by their name"));
  }
  UseRig(std::move(rig));
}

bool FrameSource::is_rgbd() const { return NamesDepth(settings_.left, settings_.right); }

void FrameSource::AddImage(Side side, ForeignImage image) {
  const auto pair = pairing_.Add(side, std::move(image));
  process_.SetCounter("frames.unpaired", static_cast<double>(pairing_.unpaired()));
  if (pair) AddPair(pair->first, pair->second);
}

void FrameSource::AddInfo(Side side, RosCameraInfo info) {
  infos_[static_cast<size_t>(side)] = std::move(info);
  if (!infos_[0] || (!infos_[1] && !is_rgbd())) return;
  // Each only once: a new one of one camera does not go with an old one of the other.
  const auto infos = std::exchange(infos_, {});
  const bool is_first = !rig_;
  const RosCameraInfo left = InPixelsOfImages(*infos[0], {});
  const bool rectified = NamesRectified(settings_.left);
  RigCalibration rig = is_rgbd()
                           ? MakeRgbdRig(CameraFromRos(left, rectified), kVirtualBaseline_m, kRosDepthUnits_per_m)
                           : RigFromRos(left, InPixelsOfImages(*infos[1], {}), rectified);
  if (T_b_l_) {
    const SE3 T_b_old = *T_b_l_ * rig.left.T_b_cam.Inverse();
    for (CameraCalibration* const camera : {&rig.left, &rig.right}) camera->T_b_cam = T_b_old * camera->T_b_cam;
  }
  UseRig(std::move(rig));
  if (!is_first) return;
  Notes notes;
  WarnOfUnusedDistortion(settings_.left, *infos[0], "give " + settings_.camera_option, &notes);
  for (const std::string& warning : notes.warnings) LogWarning("{}", warning);
}

void FrameSource::AddPair(const ForeignImage& left, const ForeignImage& right) {
  if (!rig_) return;
  if (left.t_ns == last_t_ns_) throw DatasetError("has the same stamp as the previous one");
  const cv::Size size(rig_->left.width_px, rig_->left.height_px);
  UseWhiteLevel(std::max(BrightWideValue(left, size), is_rgbd() ? 0 : BrightWideValue(right, size)));
  StereoImages images;
  images.t_ns = left.t_ns;
  images.left = GreyOf(left, size, white_);
  images.right = is_rgbd() ? DepthsOf(right, size, rig_->depth_units_per_m) : GreyOf(right, size, white_);
  last_t_ns_ = images.t_ns;
  waiting_.push_back({std::move(images), bus::NowS() + kImuWait_s});
  SendDue();
}

/// Both cameras have that of the first pair, until an image has larger values. `bright` is 0 for images of 8 bits.
void FrameSource::UseWhiteLevel(int bright) {
  if (bright == 0 || (has_white_ && bright <= white_)) return;
  has_white_ = true;
  white_ = WhiteLevel(bright);
  if (white_ < kWhiteOf16Bits) {
    LogInfo("the 16-bit images have values up to {}: {} is mapped to white", bright, white_);
  }
}

void FrameSource::UseRig(RigCalibration rig) {
  rig.name = settings_.process;
  imu_.AddTo(rig);
  std::vector<uint8_t> bytes = bus::RigBytes(bus::ToMessage(rig));
  if (bytes == rig_bytes_) return;
  CheckRig(rig);
  if (settings_.camera.empty()) {
    // Warnings of a camera file are printed when it is read.
    Notes notes;
    const std::string remedy = "P[3] is in metres times pixels; where it is not, give " + settings_.camera_option;
    WarnOfLongBaseline("CameraInfo", rig, remedy, &notes);
    for (const std::string& warning : notes.warnings) LogWarning("{}", warning);
  }
  SendAll();
  rig_bytes_ = std::move(bytes);
  rig_ = std::move(rig);
  listener_.on_rig(*rig_);
  PublishRig();
}

void FrameSource::PublishRig() {
  if (rig_) process_.bus().Publish(bus::kCamera, bus::ToMessage(*rig_));
}

void FrameSource::SendDue() {
  while (!waiting_.empty()) {
    Waiting& first = waiting_.front();
    if (bus::NowS() < first.until_s && imu_.Awaits(*rig_, first.images.t_ns)) return;
    StereoImages images = std::move(first.images);
    waiting_.pop_front();
    Publish(std::move(images));
  }
}

void FrameSource::SendAll() {
  for (Waiting& waiting : waiting_) waiting.until_s = 0.0;
  SendDue();
}

std::chrono::milliseconds FrameSource::Wait(std::chrono::milliseconds limit) const {
  constexpr std::chrono::milliseconds kPoll{1};
  return waiting_.empty() ? limit : std::min(limit, kPoll);
}

void FrameSource::Publish(StereoImages images) {
  if (n_sent_ == 0) {
    PublishStream(stream_event::kBegin, -1);
    process_.SetCounter(kLiveSource, 1.0);
    process_.SetState(process_state::kRunning);
  }
  images.frame_id = FrameId(numbers_.Next(images.t_ns));
  listener_.on_frame(images.t_ns);
  imu_.Publish(*rig_, images.t_ns);
  publisher_.Publish(images);
  process_.SetCounter("frames.sent", static_cast<double>(++n_sent_));
}

void FrameSource::PublishStream(const char* event, int64_t n_frames) {
  stream_t stream{};
  stream.header.session = process_.bus().source().value;
  stream.dataset = settings_.left;
  stream.event = event;
  stream.pace = stream_pace::kRealtime;
  stream.n_frames = n_frames;
  process_.bus().Publish(bus::kStream, std::move(stream));
}

void FrameSource::End() {
  constexpr std::chrono::milliseconds kFlush{1000};
  SendAll();
  if (n_sent_ == 0) return;
  PublishStream(stream_event::kEnd, n_sent_);
  process_.bus().Flush(kFlush);
}

}  // namespace plslam::robot
