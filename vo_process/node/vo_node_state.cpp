#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <exception>
#include <filesystem>
#include <utility>

#include "core/bus/transport/encoded.h"
#include "core/io/files/archive.h"
#include "core/process/worker.h"
#include "plslam/camera_t.hpp"
#include "plslam/command_t.hpp"
#include "vo_process/node/tracker_state.h"
#include "vo_process/node/vo_node.h"

// How a tracker that is started again goes on where the one before it was killed.

namespace plslam {
namespace {

constexpr std::chrono::milliseconds kAskPeriod(500);
// How long frames are waited for that are wanted again: a player may have to be started, too.
constexpr double kFramesWait_s = 15.0;
// How often one state is gone on with. Maybe it is what kills trackers.
constexpr int kMaxRestored = 5;

template <class Message>
Message Decoded(const std::vector<uint8_t>& bytes) {
  Message message;
  if (message.decode(bytes.data(), 0, static_cast<int>(bytes.size())) < 0) {
    throw std::runtime_error("a message in it is damaged");
  }
  return message;
}

}  // namespace

/// With the state as of the newest keyframe. In lockstep that keyframe may not have gone out, and the frames after it are
/// wanted again; a live stream goes on with a gap.
void VoNode::Restore() {
  if (options_.state_file.empty()) return;
  process_.bus().Every(kAskPeriod, [this] { AskAgainForFrames(); });
  if (!std::filesystem::exists(options_.state_file)) return;
  try {
    TrackerState state = ReadTrackerState(options_.state_file);
    if (state.settings != settings_) throw std::runtime_error("the state is of a tracker with other settings");
    if (++state.n_restored > kMaxRestored) throw std::runtime_error("all that went on with the state have died");
    WriteTrackerState(options_.state_file, state);
    GoOnWith(state);
  } catch (const std::exception& error) {
    spdlog::warn("a new session begins: {}", error.what());
    odometry_.reset();
  }
}

void VoNode::GoOnWith(const TrackerState& state) {
  OnCamera(Decoded<camera_t>(state.camera));
  if (!front_end_) return;
  odometry_.emplace(front_end_->camera(), options_);
  archive::FromBytes(state.odometry, *odometry_);
  session_ = state.session;
  lockstep_ = state.lockstep;
  last_t_ns_ = state.t_ns;
  last_frame_id_ = state.frame_id;
  last_source_ = player_ = state.source;
  for (const std::vector<uint8_t>& pose : state.poses) recent_.push_back(Decoded<pose_t>(pose));
  adrift_since_ns_ = state.adrift_since_ns;
  follows_keyframe_ = true;
  adopted_keyframe_id_ = state.adopted_keyframe_id;
  last_keyframe_id_ = state.keyframe.keyframe_id;
  restored_ = true;
  spdlog::info("goes on behind frame {} of the session", last_frame_id_);
  process_.bus().Post([this, keyframe = state.keyframe] {
    if (keyframe.keyframe_id >= 0) keyframes_.Publish(keyframe);
    // The last word of the dead may have been lost, and a player that is started again looks for it.
    if (!recent_.empty()) process_.bus().Publish(bus::kPose, pose_t(recent_.back()));
    if (lockstep_) AskForFrames();
  });
}

/// Where it cannot be written the process goes on; what a crash would cost is then more.
void VoNode::KeepState(const Keyframe& keyframe) {
  if (options_.state_file.empty() || !odometry_) return;
  TrackerState state;
  state.settings = settings_;
  state.camera = camera_bytes_;
  state.session = session_;
  state.lockstep = lockstep_;
  state.t_ns = last_t_ns_;
  state.frame_id = last_frame_id_;
  state.source = last_source_;
  for (const pose_t& pose : recent_) state.poses.push_back(bus::Encoded(pose));
  state.adrift_since_ns = adrift_since_ns_;
  state.adopted_keyframe_id = adopted_keyframe_id_;
  state.odometry = archive::ToBytes(*odometry_);
  state.keyframe = keyframe;
  try {
    WriteTrackerState(options_.state_file, state);
    Count("state.written", 1);
  } catch (const std::exception& error) {
    // An old one is worse than none: others know what came after it.
    DropState();
    if (!std::exchange(state_failed_, true)) spdlog::warn("what a restart would need is not kept: {}", error.what());
  }
}

/// Also where an exception ends the process: with the same state it might come again.
void VoNode::DropState() const {
  std::error_code ignored;
  if (!options_.state_file.empty()) std::filesystem::remove(options_.state_file, ignored);
}

/// A player is ahead of a tracker that has gone back to its newest keyframe, and so may be one that is started beside it.
bool VoNode::LacksFramesBefore(const Frame& frame) const {
  const bool continues = frame.lockstep && lockstep_ && odometry_ && frame.images.t_ns > last_t_ns_;
  const bool may_go_back = restored_ || frame.source != last_source_;
  return continues && may_go_back && frame.images.frame_id > last_frame_id_ + 1 && !options_.state_file.empty();
}

void VoNode::AskForFrames() {
  if (!frames_asked_s_) frames_asked_s_ = bus::NowS();
  command_t command{};
  command.target = "player";
  command.verb = "go_back";
  command.argument = fmt::format("{} {}@{}", player_, last_frame_id_, last_t_ns_);
  process_.bus().Publish(bus::kCommand, command);
}

void VoNode::AskAgainForFrames() {
  if (!frames_asked_s_) return;
  if (bus::NowS() - *frames_asked_s_ < kFramesWait_s) return AskForFrames();
  frames_asked_s_.reset();
  spdlog::warn("no player sends the frames behind {} again: a gap is left", last_frame_id_);
  GoOn();
}

}  // namespace plslam
