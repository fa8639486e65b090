// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/frame_inputs.h"

#include <utility>

namespace plslam::ros2 {

void FrameInputs::SetImages(robot::Side side, const std::string& topic, const std::string& type, size_t reader) {
  Reader& images = sides_[static_cast<size_t>(side)];
  images.input.topic = topic;
  images.input.type = type;
  images.number = reader;
}

void FrameInputs::AddInfo(const std::string& topic, size_t reader) {
  infos_.push_back({{topic, "sensor_msgs/msg/CameraInfo", {}, {}, {}}, reader});
}

void FrameInputs::OnImage(robot::Side side, int64_t t_ns) {
  Input& input = sides_[static_cast<size_t>(side)].input;
  input.previous_stamp_ns = std::exchange(input.stamp_ns, t_ns);
}

void FrameInputs::ReadStates(const std::function<ReaderState(size_t reader)>& state_of) {
  for (Reader& side : sides_) side.input.state = state_of(side.number);
  for (Reader& info : infos_) info.input.state = state_of(info.number);
}

bool FrameInputs::HasProgress(int64_t n_sent, double now_s) {
  if (!progress_.HasProgress(n_sent, now_s)) return false;
  n_rejected_before_ = n_rejected_;
  for (Reader& side : sides_) side.n_before = side.input.state.n_messages;
  reason_.clear();
  return true;
}

Symptoms FrameInputs::SinceProgress() const {
  Symptoms symptoms;
  symptoms.left = sides_[0].input;
  symptoms.right = sides_[1].input;
  symptoms.left.state.n_messages -= sides_[0].n_before;
  symptoms.right.state.n_messages -= sides_[1].n_before;
  for (const Reader& info : infos_) symptoms.infos.push_back(info.input);
  symptoms.n_rejected = n_rejected_ - n_rejected_before_;
  return symptoms;
}

std::string FrameInputs::SetReason(const std::string& why) { return std::exchange(reason_, why); }

}  // namespace plslam::ros2
