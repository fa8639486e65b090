// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/monitor_node.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/bus/messages/map_pages.h"
#include "core/bus/run_loop.h"
#include "core/process/process_status.h"
#include "core/process/process_usage.h"
#include "core/run/lag.h"
#include "core/run/process_names.h"
#include "plslam/keyframe_t.hpp"
#include "plslam/loop_closure_t.hpp"
#include "plslam/map_update_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/relocalisation_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/warning_t.hpp"

namespace plslam::launcher {
namespace {

// More are invented.
constexpr size_t kMaxShownProcesses = 4096;

FrameReport FromMessage(const pose_t& message) {
  FrameReport report;
  report.session = SessionId(message.header.session);
  report.frame_id = FrameId(message.frame_id);
  report.t_ns = message.header.t_ns;
  report.state = static_cast<TrackingState>(message.state);
  report.keyframe_id = message.keyframe_id;
  report.tracked_points = message.n_tracked_points;
  report.tracked_lines = message.n_tracked_lines;
  report.skipped_frames = message.n_skipped_frames;
  report.age_ms = message.age_ms;
  report.features = message.n_points + message.n_lines;
  report.moving = message.n_moving;
  report.bodies = message.n_bodies;
  for (const stage_t& stage : message.stages) report.stage_ms.emplace_back(stage.name, stage.ms);
  return report;
}

ProcessStatus FromMessage(const status_t& message) {
  ProcessStatus status{message.process, message.state, message.reason, message.configuration, {}, 0.0, 0,
                       bus::NowS()};
  const auto count = [&](const char* name) { return bus::CountOf(message, name); };
  status.messages = {count("bus.lost"), count("bus.repaired"), count("bus.rejected")};
  status.frames = count("frames");
  status.queue = bus::LongestQueueOf(message);
  return status;
}

}  // namespace

MonitorNode::MonitorNode(bus::Bus& bus) : host_(bus::HostName()) {
  const int64_t own = bus.source().value;
  bus.Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  bus.Subscribe<pose_t>(bus::kPose, [this, own](const pose_t& m) {
    if (m.header.source == own) return;
    statistics_.AddFrame(FromMessage(m));
    ++poses_heard_;
  });
  bus.Subscribe<stream_t>(bus::kStream, [this, own](const stream_t& m) {
    if (m.header.source == own) return;
    total_frames_ = m.n_frames;
    sent_.OnStream(m.event == stream_event::kEnd, m.n_frames, m.n_bad);
    lockstep_ = m.pace == stream_pace::kLockstep;
  });
  bus.Subscribe<warning_t>(bus::kWarning, [this](const warning_t& m) { warnings_.Add(m.code, m.sentence); });
  bus.Subscribe<keyframe_t>(bus::kKeyframe, [this](const keyframe_t& m) {
    for (const auto& point : m.points)
      statistics_.AddLandmark(SessionId(m.header.session), TrackId(point.landmark_id), false);
    for (const auto& line : m.lines)
      statistics_.AddLandmark(SessionId(m.header.session), TrackId(line.landmark_id), true);
  });
  bus.Subscribe<map_update_t>(bus::kMapUpdate, [this](const map_update_t& m) {
    const auto head = m.page == 0 ? bus::HeadOf(m) : std::nullopt;
    if (head) map_.Add(*head);
  });
  bus.Subscribe<loop_closure_t>(bus::kLoopClosure, [this, own](const loop_closure_t& m) {
    if (m.page == 0 && m.header.source != own) {
      loops_.Add(static_cast<LoopClosure::Kind>(m.kind), m.detect_ms, m.correct_ms);
    }
  });
  bus.Subscribe<relocalisation_t>(bus::kRelocalisation,
                                  [this](const relocalisation_t& m) { loops_.AddAnswer(m.found != 0); });
}

void MonitorNode::OnStatus(const status_t& message) {
  if (process_name::SendsFrames(message.process)) {
    player_heard_s_ = bus::NowS();
    is_paused_ = bus::CounterOf(message, kSenderPaused) > 0.0;
    sent_.OnStatus(bus::CountOf(message, "frames.sent"), bus::CountOf(message, "frames.bad"));
  }
  for (const counter_t& counter : message.counters)
    counters_.Take(SourceId(message.header.source), counter.name, counter.value);
  const std::pair process(message.host, message.pid);
  if (processes_.size() >= kMaxShownProcesses && !processes_.contains(process)) return;
  const ProcessStatus& status = processes_[process] = FromMessage(message);
  if (longest_queue_.size() >= kMaxShownProcesses && !longest_queue_.contains(message.process)) return;
  double& longest = longest_queue_[message.process];
  longest = std::max(longest, status.queue);
}

bool MonitorNode::PlayerWaitsForTime(double now_s) const {
  const bool heard = player_heard_s_ >= 0.0 && now_s - player_heard_s_ < kGoneAfter_s;
  if (is_paused_) return heard;
  if (sent_.ended() || lockstep_) return false;
  return heard && sent_.sent() > 0 && sent_.Behind(statistics_.newest_frame().first) == 0;
}

SignsOfLife MonitorNode::Signs(int64_t viewer, double now_s) const {
  const auto found = processes_.find({host_, viewer});
  return {poses_heard_, map_.version(), PlayerWaitsForTime(now_s), sent_.ended(),
          found == processes_.end() ? -1.0 : found->second.heard_s};
}

FrameTally MonitorNode::frames() const {
  FrameTally frames = statistics_.frames();
  frames.unreadable = sent_.unreadable();
  frames.unanswered = sent_.Unanswered(frames);
  return frames;
}

/// Poses arrive in order: with that of the last frame all have arrived.
bool MonitorNode::HasAllPoses() const {
  return sent_.ended() && (frames().unanswered == 0 || sent_.Behind(statistics_.newest_frame().first) == 0);
}

bool MonitorNode::KeyframesWait(double now_s) const {
  return std::ranges::any_of(processes_, [&](const auto& p) {
    const ProcessStatus& status = p.second;
    const bool has_keyframes = status.process == process_name::kMapping || status.process == process_name::kLoop;
    return has_keyframes && status.queue > 0.0 && now_s - status.heard_s < kGoneAfter_s;
  });
}

EndSigns MonitorNode::SignsOfEnd(const Processes& processes, double now_s) const {
  const std::string state = StateOf(processes.sender);
  EndSigns signs;
  signs.stream_ended = sent_.ended();
  signs.source_sends = state == process_state::kReady || state == process_state::kRunning;
  signs.tracker_finished = StateOf(processes.tracker) == process_state::kFinished;
  signs.has_all_poses = HasAllPoses();
  signs.poses = poses_heard_;
  signs.has_map = !processes.has_mapper || map_.newest().HasCommitted(statistics_.last_keyframe());
  signs.map_version = map_.version();
  signs.maps = processes.has_mapper && KeyframesWait(now_s);
  return signs;
}

KeyframeName MonitorNode::committed_keyframe() const {
  const KeyframeName newest = statistics_.last_keyframe();
  return map_.newest().HasCommitted(newest) ? newest : KeyframeName();
}

std::string MonitorNode::StateOf(int64_t pid) const {
  const auto found = processes_.find({host_, pid});
  return found == processes_.end() ? "" : found->second.state;
}

std::string MonitorNode::ReasonOf(int64_t pid) const {
  const auto found = processes_.find({host_, pid});
  return found == processes_.end() ? "" : found->second.reason;
}

std::string MonitorNode::FailureOf(int64_t pid) const {
  const auto found = processes_.find({host_, pid});
  return found == processes_.end() || found->second.state != process_state::kFailed ? "" : found->second.reason;
}

int64_t MonitorNode::FramesOf(int64_t pid) const {
  const auto found = processes_.find({host_, pid});
  return found == processes_.end() ? 0 : found->second.frames;
}

bool MonitorNode::Hears(const std::string& process) const {
  return std::ranges::any_of(processes_, [&](const auto& p) { return p.second.process == process; });
}

Lag MonitorNode::LagAt(double now_s) const {
  Lag lag{"", longest_queue_};
  double furthest = 0.0;
  for (const auto& [process, status] : processes_) {
    const double silent_s = now_s - status.heard_s;
    // An exited process is ignored; its replacement has its own status.
    const Pace pace = PaceOf(status.state, silent_s, status.queue);
    if (pace == Pace::kSilent)
      return {fmt::format("{}: silent for {:.0f} s", status.process, silent_s), longest_queue_};
    if (pace != Pace::kBehind || status.queue < furthest) continue;
    furthest = status.queue;
    lag.text = fmt::format("{}: {:.0f} waiting", status.process, status.queue);
  }
  return lag;
}

MessageCounts MonitorNode::messages() const {
  MessageCounts sum;
  for (const auto& [process, status] : processes_) {
    sum.lost += status.messages.lost;
    sum.repaired += status.messages.repaired;
    sum.rejected += status.messages.rejected;
  }
  return sum;
}

}  // namespace plslam::launcher
