// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/image_source.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/robot/image_topics.h"
#include "core/run/process_names.h"

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

std::string GivenOr(const std::string& given, const std::string& image_channel) {
  return given.empty() ? InfoChannelOf(image_channel) : given;
}

}  // namespace

std::string InfoChannelOf(const std::string& image_channel) {
  const size_t hash = image_channel.find('#');
  const std::string topic = robot::InfoTopicOf(std::string_view(image_channel).substr(0, hash));
  return topic + (hash == std::string::npos ? "" : "#sensor_msgs.CameraInfo");
}

ImageSource::ImageSource(bus::Process& process, bus::StockLcm& foreign, const AdapterOptions& options,
                         robot::FrameSource::Listener listener)
    : process_(process),
      options_(options),
      left_info_(GivenOr(options.left_info, options.left)),
      right_info_(GivenOr(options.right_info, options.right)),
      inbox_(options.camera.empty() ? 2 * kRoom : kRoom),  // of images beside their CameraInfo
      frames_(process,
              {.process = process_name::kAdapter,
               .camera_option = "adapter.camera",
               .camera = options.camera,
               .left = options.images.empty() ? options.left : options.images,
               .right = options.images.empty() ? options.right : "",
               .max_skew_ns = std::llround(options.max_skew_ms * kNsPerMs),
               .imu = {.name = options.imu,
                       .option = "adapter.imu",
                       .calibration = options.imu_calibration,
                       .camera = options.camera}},
              std::move(listener)),
      progress_(bus::NowS()) {
  Subscribe(foreign);
}

void ImageSource::Subscribe(bus::StockLcm& foreign) {
  const auto listen = [&](const std::string& name, std::function<void(MessageBytes)> take) {
    foreign.Subscribe(name, [this, i = channels_.size()](MessageBytes bytes) { inbox_.Put(i, bytes); });
    channels_.push_back({name, std::move(take)});
  };
  if (!options_.imu.empty()) foreign.Subscribe(options_.imu, [this](MessageBytes bytes) { OnImu(bytes); });
  if (!options_.images.empty()) {
    listen(options_.images, [this](MessageBytes bytes) {
      ++received_.n_messages[0];
      const auto [left, right] = PairFromBytes(bytes);
      frames_.AddPair(left, right);
    });
    return;
  }
  listen(options_.left, [this](MessageBytes bytes) { OnImage(robot::Side::kLeft, bytes); });
  listen(options_.right, [this](MessageBytes bytes) { OnImage(robot::Side::kRight, bytes); });
  if (!options_.camera.empty()) return;
  listen(left_info_, [this](MessageBytes bytes) { frames_.AddInfo(robot::Side::kLeft, CameraInfoFromBytes(bytes)); });
  listen(right_info_,
         [this](MessageBytes bytes) { frames_.AddInfo(robot::Side::kRight, CameraInfoFromBytes(bytes)); });
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
    if (const auto message = inbox_.Take(frames_.Wait(limit))) Handle(*message);
    frames_.SendDue();
  }
}

/// An invalid message is not a reason to exit.
void ImageSource::Handle(const robot::Inbox::Message& message) {
  const Channel& channel = channels_[message.channel];
  try {
    channel.take(message.bytes);
  } catch (const DatasetError& error) {
    process_.SetCounter("frames.rejected", static_cast<double>(++received_.n_rejected));
    skipped_messages_.WarnOnce(fmt::format("a message on {} {}", Shown(channel.name), error.what()));
  }
}

void ImageSource::OnImage(robot::Side side, MessageBytes bytes) {
  ++received_.n_messages[static_cast<size_t>(side)];
  frames_.AddImage(side, ImageFromBytes(bytes));
}

/// A sample is small, and frames wait for it: it passes by the images in the inbox.
void ImageSource::OnImu(MessageBytes bytes) {
  try {
    frames_.imu().Add(ImuSampleFromBytes(bytes));
  } catch (const DatasetError& error) {
    process_.SetCounter("imu.rejected", static_cast<double>(++n_imu_rejected_));
    skipped_samples_.WarnOnce(fmt::format("a message on {} {}", Shown(options_.imu), error.what()));
  }
}

void ImageSource::Tick() {
  frames_.PublishRig();
  process_.SetCounter("frames.dropped", static_cast<double>(inbox_.dropped()));
  if (n_sent() == 0) ListImageChannels();
  ReportLack();
}

/// An outage has one warning, however its causes change.
void ImageSource::ReportLack() {
  const double now_s = bus::NowS();
  if (progress_.HasProgress(n_sent(), now_s)) {
    received_before_ = received_;
    process_.SetReason("");
    if (std::exchange(is_out_, false)) LogInfo("frames arrive again");
  } else if (n_sent() == 0) {
    process_.SetReason(WhatIsMissing());
  } else if (progress_.IsLate(now_s)) {
    const std::string why = WhatIsMissing();
    process_.SetReason(why);
    if (std::exchange(is_out_, true)) return;
    process_.SetCounter("frames.outages", static_cast<double>(++n_outages_));
    const std::string sentence = "no frames: " + why;
    if (!process_.Warn("adapter_no_frames", sentence)) LogWarning("{}", sentence);
  }
}

/// Channels of images on which nothing has arrived since the last progress.
std::vector<std::string> ImageSource::SilentChannels() const {
  const auto is_silent = [this](size_t side) {
    return received_.n_messages[side] == received_before_.n_messages[side];
  };
  std::vector<std::string> silent;
  if (!options_.images.empty()) {
    if (is_silent(0)) silent.push_back(Shown(options_.images));
    return silent;
  }
  if (is_silent(static_cast<size_t>(robot::Side::kLeft))) silent.push_back(Shown(options_.left));
  if (is_silent(static_cast<size_t>(robot::Side::kRight))) silent.push_back(Shown(options_.right));
  return silent;
}

/// Once, while an expected channel is silent: a mistyped name is the most likely reason.
void ImageSource::ListImageChannels() {
  if (image_channels_ || SilentChannels().empty() || std::chrono::steady_clock::now() < list_at_) return;
  const std::vector<std::string> channels = ImageChannels(options_.foreign_url, kListTime);
  image_channels_ = channels.empty() ? "no channel of adapter.foreign_url has images"
                                     : fmt::format("images are on {}", fmt::join(channels, ", "));
  LogWarning("{}", WhatIsMissing());
}

std::string ImageSource::WhatIsMissing() const {
  const std::vector<std::string> silent = SilentChannels();
  if (!silent.empty()) {
    const std::string waits = fmt::format("waiting for images on {}", fmt::join(silent, " and "));
    return n_sent() > 0 ? waits : Joined(waits, Shown(image_channels_.value_or("")));
  }
  if (!frames_.has_rig()) {
    return fmt::format("waiting for sensor_msgs.CameraInfo on {} and {} (or give a file with --camera)", left_info_,
                       right_info_);
  }
  return received_.n_rejected > received_before_.n_rejected
             ? "no image could be used: see the log"
             : "no left image has nearly the same stamp as a right one";
}

}  // namespace plslam::adapter
