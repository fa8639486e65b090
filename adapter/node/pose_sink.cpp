// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/pose_sink.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "adapter/node/foreign_messages.h"
#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/run/tracking_state.h"
#include "plslam/pose3_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/stage_t.hpp"

namespace plslam::adapter {
namespace {

/// Number of frames whose poses are expected, and of waiting poses: seconds of a camera, and bounded.
constexpr size_t kMostFrames = 256;
constexpr std::chrono::milliseconds kTick{1000};

std::optional<robot::CameraPose> FromMessage(const pose_t& message) {
  const auto T_odom_c = bus::FromMessage(message.T_odom_c), T_w_odom = bus::FromMessage(message.T_w_odom),
             T_prev_c = bus::FromMessage(message.T_prev_c);
  const auto covariance = bus::FromArray(message.covariance);
  const auto motion_covariance = bus::FromArray(message.motion_covariance);
  if (!T_odom_c || !T_w_odom || !T_prev_c || !covariance || !motion_covariance) return std::nullopt;
  return robot::CameraPose{message.header.t_ns, *T_w_odom, message.anchored != 0, *T_odom_c,
                           *covariance,         *T_prev_c, *motion_covariance,    {}};
}

}  // namespace

PoseSink::PoseSink(bus::Process& process, bus::StockLcm& foreign, const AdapterOptions& options)
    : process_(process), foreign_(foreign), options_(options), inbox_(std::make_shared<robot::Inbox>(kMostFrames)) {
  process_.bus().SubscribeBytes(
      bus::kPose, bus::Bus::Reading::kAsItComes, [] { return true; },
      [weak = std::weak_ptr<robot::Inbox>(inbox_)](bus::ByteView bytes) {
        if (const auto inbox = weak.lock()) inbox->Put(0, bytes);
      });
  thread_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { Work(); }); });
}

PoseSink::~PoseSink() {
  inbox_->Stop();
  thread_.join();
}

void PoseSink::SetBody(const SE3& T_b_c) {
  const std::scoped_lock lock(mutex_);
  T_b_c_ = T_b_c;
}

void PoseSink::OnFrame(int64_t t_ns) {
  const std::scoped_lock lock(mutex_);
  if (frames_.size() >= kMostFrames) frames_.pop_front();
  frames_.push_back(t_ns);
}

void PoseSink::Work() {
  while (!inbox_->stopped()) {
    const auto taken = inbox_->Take(kTick);
    if (!taken) continue;
    if (const auto message = bus::Decoded<pose_t>(taken->bytes)) Send(*message);
  }
}

/// Returns T_b_c if the pose is the first one of a frame that was sent from here.
std::optional<SE3> PoseSink::BodyOf(const pose_t& message) {
  const std::scoped_lock lock(mutex_);
  const auto frame = std::find(frames_.begin(), frames_.end(), message.header.t_ns);
  if (frame == frames_.end()) return std::nullopt;
  frames_.erase(frame);
  return T_b_c_;
}

template <class Message>
void PoseSink::Publish(const std::string& channel, const Message& message) {
  if (channel.empty() || foreign_.Publish(channel, bus::Encoded(message))) return;
  process_.SetCounter("poses.failed", static_cast<double>(++n_failed_));
}

void PoseSink::Send(const pose_t& message) {
  const std::optional<SE3> T_b_c = BodyOf(message);
  const auto state = static_cast<TrackingState>(message.state);
  // Before tracking starts, motion and covariance are zero and carry no information.
  if (!T_b_c || state == TrackingState::kInitialising) return;
  std::optional<robot::CameraPose> camera = FromMessage(message);
  if (!camera) return process_.bus().CountRejected();
  camera->dt_s = steps_.SecondsSinceLast(message);
  const robot::BodyPose pose = robot::ToBody(*T_b_c, *camera);
  // A bot_core pose has no covariance, so its readers could not distinguish a prediction from an estimate.
  if (state != TrackingState::kLost && pose.anchored) Publish(options_.pose, ToBotPose(pose));
  Publish(options_.odometry, ToOdometry(BodyOdometry(pose, names_)));
  Publish(options_.tf, ToTransforms(pose.t_ns, BodyTransforms(pose, names_)));
  process_.SetCounter("poses.sent", static_cast<double>(++n_sent_));
}

}  // namespace plslam::adapter
