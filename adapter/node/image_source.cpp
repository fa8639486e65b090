// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/image_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/frame_assembler.h"
#include "core/datasets/calibrations/camera_info.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/check_rig.h"
#include "core/errors/error_text.h"
#include "core/geometry/body_frame.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "plslam/camera_t.hpp"
#include "plslam/intrinsics_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam::adapter {
namespace {

constexpr double kNsPerMs = 1e6;
constexpr std::chrono::milliseconds kTick{1000};
/// Silence of the expected channels after which others are listed, and the time of listening to them.
constexpr std::chrono::seconds kListAfter{3};
constexpr std::chrono::milliseconds kListTime{1000};
/// Number of waiting messages: two pairs of images. Older images are of no use to a moving robot.
constexpr size_t kRoom = 4;

/// Returns the channels of `url` on which images arrive within this time, sorted; empty if nothing can be received.
std::vector<std::string> ImageChannels(const std::string& url, std::chrono::milliseconds time) {
  std::set<std::string, std::less<>> channels;
  try {
    bus::ReceiveAll(url, "adapter.foreign_url", time, [&](std::string_view channel, bus::ByteView bytes) {
      if (IsOfImages(bytes)) channels.emplace(channel);
    });
  } catch (const std::runtime_error&) {
    // The subscriptions of `ImageSource` report what cannot be received.
  }
  return {channels.begin(), channels.end()};
}

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

/// Warns about the baseline of a CameraInfo. The notes of a camera file are printed when it is read.
void WarnOfLongBaseline(const RigCalibration& rig) {
  Notes notes;
  plslam::WarnOfLongBaseline("CameraInfo", rig,
                             "P[3] is in metres times pixels; where it is not, give adapter.camera", &notes);
  for (const std::string& warning : notes.warnings) spdlog::warn("{}", warning);
}

std::string GivenOr(const std::string& given, const std::string& image_channel) {
  return given.empty() ? InfoChannelOf(image_channel) : given;
}

}  // namespace

std::string InfoChannelOf(const std::string& image_channel) {
  const size_t hash = image_channel.find('#');
  std::string topic = image_channel.substr(0, hash);
  constexpr std::string_view kCompressed = "/compressed";
  if (topic.ends_with(kCompressed)) topic.resize(topic.size() - kCompressed.size());
  const size_t slash = topic.rfind('/');
  if (slash != std::string::npos && topic.compare(slash + 1, 5, "image") == 0) topic.resize(slash);
  return topic + "/camera_info" + (hash == std::string::npos ? "" : "#sensor_msgs.CameraInfo");
}

ImageSource::ImageSource(bus::Process& process, bus::StockLcm& foreign, const AdapterOptions& options,
                         Listener listener)
    : process_(process),
      options_(options),
      left_info_(GivenOr(options.left_info, options.left)),
      right_info_(GivenOr(options.right_info, options.right)),
      listener_(std::move(listener)),
      inbox_(options.camera.empty() ? 2 * kRoom : kRoom),  // of images beside their CameraInfo
      publisher_(process.bus(), false),
      pairing_(std::llround(options.max_skew_ms * kNsPerMs)) {
  if (!options_.camera.empty()) {
    Notes notes;
    RigCalibration rig = ReadCalibration({options_.camera}, {}, &notes);
    for (const std::string& warning : notes.warnings) spdlog::warn("{}", warning);
    for (const std::string& remark : notes.remarks) spdlog::info("{}", remark);
    if (rig.kind != RigCalibration::Kind::kStereo) {
      throw DatasetError(options_.camera + ": is for an RGB-D camera, but a stereo rig is required");
    }
    UseRig(std::move(rig));
  }
  Subscribe(foreign);
}

void ImageSource::Subscribe(bus::StockLcm& foreign) {
  const auto listen = [&](const std::string& name, std::function<void(MessageBytes)> take) {
    foreign.Subscribe(name, [this, i = channels_.size()](MessageBytes bytes) { inbox_.Put(i, bytes); });
    channels_.push_back({name, std::move(take)});
  };
  if (!options_.images.empty()) {
    listen(options_.images, [this](MessageBytes bytes) {
      ++n_messages_[0];
      OnPair(PairFromBytes(bytes));
    });
    return;
  }
  listen(options_.left, [this](MessageBytes bytes) { OnImage(Side::kLeft, bytes); });
  listen(options_.right, [this](MessageBytes bytes) { OnImage(Side::kRight, bytes); });
  if (!options_.camera.empty()) return;
  listen(left_info_, [this](MessageBytes bytes) { OnInfo(Side::kLeft, bytes); });
  listen(right_info_, [this](MessageBytes bytes) { OnInfo(Side::kRight, bytes); });
}

void ImageSource::Work() {
  auto due = std::chrono::steady_clock::now();
  list_at_ = due + kListAfter;
  while (!inbox_.stopped()) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= due) {
      Tick();
      due = now + kTick;
    }
    const auto limit = std::chrono::ceil<std::chrono::milliseconds>(due - now);
    if (const auto message = inbox_.Take(limit)) Handle(*message);
  }
}

/// An invalid message is not a reason to exit.
void ImageSource::Handle(const Inbox::Message& message) {
  const Channel& channel = channels_[message.channel];
  try {
    channel.take(message.bytes);
  } catch (const DatasetError& error) {
    process_.SetCounter("frames.rejected", static_cast<double>(++n_rejected_));
    skipped_messages_.WarnOnce(fmt::format("a message on {} {}", Shown(channel.name), error.what()));
  }
}

void ImageSource::OnImage(Side side, MessageBytes bytes) {
  ++n_messages_[static_cast<size_t>(side)];
  const auto pair = pairing_.Add(side, ImageFromBytes(bytes));
  process_.SetCounter("frames.unpaired", static_cast<double>(pairing_.unpaired()));
  if (pair) OnPair(*pair);
}

void ImageSource::OnInfo(Side side, MessageBytes bytes) {
  infos_[static_cast<size_t>(side)] = CameraInfoFromBytes(bytes);
  if (!infos_[0] || !infos_[1]) return;
  // Each only once: a new one of one camera does not go with an old one of the other.
  const auto infos = std::exchange(infos_, {});
  const bool is_first = !rig_;
  UseRig(RigFromRos(InPixelsOfImages(*infos[0], {}), InPixelsOfImages(*infos[1], {}), NamesRectified(options_.left)));
  if (!is_first) return;
  Notes notes;
  WarnOfUnusedDistortion(options_.left, *infos[0], "give adapter.camera", &notes);
  for (const std::string& warning : notes.warnings) spdlog::warn("{}", warning);
}

void ImageSource::OnPair(const Pair& pair) {
  if (!rig_) return;
  if (pair.first.t_ns == last_t_ns_) throw DatasetError("has the same stamp as the previous one");
  const cv::Size size(rig_->left.width_px, rig_->left.height_px);
  UseWhiteLevel(std::max(BrightWideValue(pair.first, size), BrightWideValue(pair.second, size)));
  StereoImages images;
  images.t_ns = pair.first.t_ns;
  images.left = GreyOf(pair.first, size, white_);
  images.right = GreyOf(pair.second, size, white_);
  Publish(std::move(images));
}

/// Both cameras have that of the first pair, until an image has larger values. `bright` is 0 for images of 8 bits.
void ImageSource::UseWhiteLevel(int bright) {
  if (bright == 0 || (has_white_ && bright <= white_)) return;
  has_white_ = true;
  white_ = WhiteLevel(bright);
  if (white_ < kWhiteOf16Bits) {
    spdlog::info("the 16-bit images have values up to {}: {} is mapped to white", bright, white_);
  }
}

void ImageSource::UseRig(RigCalibration rig) {
  rig.name = process_name::kAdapter;
  std::vector<uint8_t> bytes = bus::RigBytes(bus::ToMessage(rig));
  if (bytes == rig_bytes_) return;
  CheckRig(rig);
  if (options_.camera.empty()) WarnOfLongBaseline(rig);
  rig_bytes_ = std::move(bytes);
  rig_ = std::move(rig);
  listener_.on_rig(*rig_);
  PublishRig();
}

void ImageSource::PublishRig() { process_.bus().Publish(bus::kCamera, bus::ToMessage(*rig_)); }

void ImageSource::Publish(StereoImages images) {
  if (n_sent_ == 0) {
    stream_t stream{};
    stream.header.session = process_.bus().source();
    stream.dataset = options_.images.empty() ? options_.left : options_.images;
    stream.event = "begin";
    stream.pace = "realtime";
    stream.n_frames = -1;
    process_.bus().Publish(bus::kStream, std::move(stream));
    process_.SetCounter(kLiveSource, 1.0);
    process_.SetState(process_state::kRunning);
  }
  images.frame_id = numbers_.Next(images.t_ns);
  last_t_ns_ = images.t_ns;
  listener_.on_frame(images.t_ns);
  publisher_.Publish(images);
  process_.SetCounter("frames.sent", static_cast<double>(++n_sent_));
}

void ImageSource::Tick() {
  if (rig_) PublishRig();
  process_.SetCounter("frames.dropped", static_cast<double>(inbox_.dropped()));
  ListImageChannels();
  if (n_sent_ == 0) process_.SetReason(WhatIsMissing());
}

/// Channels of images on which nothing has arrived.
std::vector<std::string> ImageSource::SilentChannels() const {
  std::vector<std::string> silent;
  if (!options_.images.empty()) {
    if (n_messages_[0] == 0) silent.push_back(Shown(options_.images));
    return silent;
  }
  if (n_messages_[static_cast<size_t>(Side::kLeft)] == 0) silent.push_back(Shown(options_.left));
  if (n_messages_[static_cast<size_t>(Side::kRight)] == 0) silent.push_back(Shown(options_.right));
  return silent;
}

/// Once, while an expected channel is silent: a mistyped name is the most likely reason.
void ImageSource::ListImageChannels() {
  if (image_channels_ || SilentChannels().empty() || std::chrono::steady_clock::now() < list_at_) return;
  const std::vector<std::string> channels = ImageChannels(options_.foreign_url, kListTime);
  image_channels_ = channels.empty() ? "no channel of adapter.foreign_url has images"
                                     : fmt::format("images are on {}", fmt::join(channels, ", "));
  spdlog::warn("{}", WhatIsMissing());
}

std::string ImageSource::WhatIsMissing() const {
  const std::vector<std::string> silent = SilentChannels();
  if (!silent.empty()) {
    return Joined(fmt::format("waiting for images on {}", fmt::join(silent, " and ")),
                  Shown(image_channels_.value_or("")));
  }
  if (!rig_) {
    return fmt::format("waiting for sensor_msgs.CameraInfo on {} and {} (or give a file with --camera)", left_info_,
                       right_info_);
  }
  return n_rejected_ > 0 ? "no image could be used: see the log"
                         : "no left image has nearly the same stamp as a right one";
}

}  // namespace plslam::adapter
