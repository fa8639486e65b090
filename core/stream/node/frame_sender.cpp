// SPDX-License-Identifier: BSD-3-Clause
#include "core/stream/node/frame_sender.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/imu_channel.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/files/dataset_error.h"
#include "core/process/order.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "plslam/camera_t.hpp"
#include "plslam/command_t.hpp"
#include "plslam/ground_truth_t.hpp"
#include "plslam/pose3_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"

namespace plslam::stream {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kRigPeriod{1000};
constexpr milliseconds kWaitingTick{1000};
// A restarted vo_process gets the pending frame from the bus if the bus still has it; after this many ticks the sender
// resends it.
constexpr int kTicksBeforeResend = 2;
// A link that is cut for longer than the bus retries may cost vo_process a part of the frame: after this many more
// ticks without a pose the frame is resent. A reader that already has the frame ignores it.
constexpr int kTicksBeyondTheBus = 12;
constexpr milliseconds kFlushTick{500};
// A restarted process learns from the bus which frame was answered last: it stops listening after this time without
// another pose, and waits at most `kNoPoses` for the first one.
constexpr milliseconds kPosesQuiet{1000};
constexpr milliseconds kNoPoses{5000};
constexpr milliseconds kResumeTick{50};

int64_t Now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Turn::Clock::now().time_since_epoch()).count();
}

}  // namespace

FrameSender::FrameSender(bus::Process& process, std::unique_ptr<FrameSource> source, const SenderOptions& options)
    : process_(process),
      options_(options),
      source_(std::move(source)),
      clock_(options.pace.speed, source_->period_ns()),
      publisher_(process.bus(), options.pace.lockstep) {
  if (source_->size() >= 0) process_.SetCounter("frames.total", static_cast<double>(source_->size()));
  if (source_->is_live()) process_.SetCounter(kLiveSource, 1.0);
  if (!options_.resume_after.empty() && options_.resume_after != kResumeFromBus) {
    resume_ = ParseResumePoint(options_.resume_after);
  }
  process_.bus().Subscribe<command_t>(bus::kCommand, [this](const command_t& command) { OnCommand(command); });
  if (options_.pace.lockstep || !options_.resume_after.empty()) {
    process_.bus().Subscribe<pose_t>(bus::kPose, [this](const pose_t& pose) {
      turn_.OnPose({FrameId(pose.frame_id), pose.header.t_ns});
    });
    process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& status) {
      if (status.process == process_name::kVo) turn_.OnReader(SourceId(status.header.source));
    });
  }
  PublishRig();
  process_.bus().Every(kRigPeriod, [this] { PublishRig(); });
  process_.SetState(process_state::kReady);
  if (options_.paused) SetPaused(true);
  sender_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { SendAll(); }); });
}

FrameSender::~FrameSender() {
  turn_.Stop();
  source_->Stop();
  sender_.join();
}

/// Publishes the state if the phase is another one.
void FrameSender::Enter(Phase phase, const std::string& reason) {
  if (std::exchange(phase_, phase) == phase) return;
  const char* const state = phase == Phase::kReady      ? process_state::kReady
                            : phase == Phase::kFinished ? process_state::kFinished
                                                        : process_state::kRunning;
  process_.SetState(state, reason);
}

void FrameSender::OnCommand(const command_t& command) {
  const std::optional<bus::Order> order = bus::OrderTo(process_, command);
  if (!order) return;
  if (order->verb == command_verb::kPause || order->verb == command_verb::kResume) {
    SetPaused(order->verb == command_verb::kPause);
    bus::Answer(process_, *order);
  } else if (order->verb == command_verb::kGoBack && options_.pace.lockstep) {
    OnGoBack(command);
  }
}

void FrameSender::SetPaused(bool paused) {
  process_.SetCounter(kSenderPaused, paused ? 1.0 : 0.0);
  turn_.SetPaused(paused);
  process_.SetReason(paused ? "paused; continue with `plslam resume`" : "");
}

void FrameSender::OnGoBack(const command_t& command) {
  const size_t space = command.argument.find(' ');
  // A command for the previous process with this name has already been obeyed or is sent again.
  if (command.argument.substr(0, space) != std::to_string(process_.bus().source().value)) return;
  try {
    turn_.OnGoBack(SourceId(command.header.source), ParseResumePoint(command.argument.substr(space + 1)));
  } catch (const std::exception& error) {
    LogWarning("the command 'go_back' is ignored: {}", error.what());
  }
}

/// Poses on the bus come from the history of vo_process, all at once.
std::optional<ResumePoint> FrameSender::WhereToResume() {
  if (options_.resume_after != kResumeFromBus) return resume_;
  const auto began = Turn::Clock::now();
  auto changed = began;
  std::optional<ResumePoint> newest;
  for (auto now = began; now - changed < (newest ? kPosesQuiet : kNoPoses); now = Turn::Clock::now()) {
    if (!turn_.WaitUntil(now + kResumeTick)) return std::nullopt;
    if (turn_.newest() == newest) continue;
    newest = turn_.newest();
    changed = Turn::Clock::now();
  }
  return newest;
}

/// Begins from the first frame, or after the resume point. Returns false if the process ends.
bool FrameSender::Begin(const std::optional<ResumePoint>& resume) {
  if (resume) {
    n_sent_ = resume->frame_id.value + 1;
    newest_sent_ = std::max(newest_sent_, resume->frame_id);
    process_.SetCounter("frames.resumed_at", static_cast<double>(n_sent_));
    LogInfo("resuming after frame {}", resume->frame_id);
  }
  n_bad_ = source_->Begin(resume);
  return !turn_.stopped();
}

void FrameSender::SendAll() {
  const std::optional<ResumePoint> resume = WhereToResume();
  if (resume) turn_.Resume();
  if (!Begin(resume)) return;
  PublishStream(resume ? stream_event::kResume : stream_event::kBegin, source_->size());
  do {
    if (!SendRest()) return;
    PublishStream(stream_event::kEnd, n_sent_);
  } while (IsRewound());
}

/// If the source fails, the end of the stream is published, so that readers finish the frames that were sent.
std::optional<LoadedFrame> FrameSender::NextFrame() {
  try {
    return source_->Next();
  } catch (...) {
    if (n_sent_ > 0) PublishEnd();
    throw;
  }
}

void FrameSender::PublishEnd() {
  PublishStream(stream_event::kEnd, n_sent_);
  process_.bus().Flush(kFlushTick);
}

/// Sends the remaining frames; returns false if the process ends first.
bool FrameSender::SendRest() {
  while (std::optional<LoadedFrame> frame = NextFrame()) {
    if (!frame->error.empty()) {
      PassOver(*frame);
      continue;
    }
    frame->images.frame_id = FrameId(n_sent_);
    const Sent sent = Send(*frame);
    if (sent == Sent::kStopped || (sent == Sent::kGoBack && !Begin(turn_.GoBack()))) return false;
  }
  return !turn_.stopped();
}

/// Waits until the readers have everything, or have made no progress for too long. Returns false if the process ends,
/// or frames are requested again, first.
bool FrameSender::WaitForReaders(bool silent_too) {
  constexpr milliseconds kNow{0};
  const std::chrono::duration<double> patience(process_.bus().options().give_up_s);
  int64_t acknowledged = process_.bus().acknowledged();
  auto changed = Turn::Clock::now();
  while (!turn_.stopped() && !turn_.WaitForRewind(kNow)) {
    if (silent_too ? process_.bus().FlushToSilent(kFlushTick) : process_.bus().Flush(kFlushTick)) return true;
    const auto now = Turn::Clock::now();
    if (std::exchange(acknowledged, process_.bus().acknowledged()) != acknowledged) changed = now;
    if (now - changed < patience) continue;
    LogWarning("readers with missing messages have acknowledged none for {} s: continuing without them",
               patience.count());
    return true;
  }
  return false;
}

/// Frames may be requested again after the end of the stream, too, as long as the process runs.
bool FrameSender::IsRewound() {
  if (WaitForReaders()) {
    Enter(Phase::kFinished, fmt::format("{} frames sent, {} bad, {} late", n_sent_, n_bad_, n_late_));
    if (options_.exit && WaitForReaders(true)) process_.Finish();
    while (!turn_.stopped() && !turn_.WaitForRewind(kWaitingTick)) {
    }
  }
  return !turn_.stopped() && Begin(turn_.GoBack());
}

/// Waits only with a frame that has not been sent before; nullopt: the frame may be sent now.
std::optional<FrameSender::Sent> FrameSender::WaitWhilePaused(FrameId frame_id) {
  if (frame_id <= newest_sent_) return std::nullopt;
  const int64_t began_ns = Now_ns();
  const Turn::Event event = turn_.WaitWhilePaused();
  clock_.Delay(Now_ns() - began_ns);
  if (event == Turn::Event::kStopped) return Sent::kStopped;
  if (event == Turn::Event::kGoBack) return Sent::kGoBack;
  return std::nullopt;
}

FrameSender::Sent FrameSender::Send(const LoadedFrame& frame) {
  const bool waits = !options_.pace.lockstep && !source_->is_live();
  if (waits && !WaitUntilDue(frame.images.t_ns)) return Sent::kStopped;
  if (!turn_.is_running()) {
    if (source_->is_live()) return Sent::kAnswered;  // a live frame that is not needed
    if (const std::optional<Sent> sent = WaitWhilePaused(frame.images.frame_id)) return *sent;
  }
  turn_.Expect({frame.images.frame_id, frame.images.t_ns});
  PublishTruth(frame);
  PublishFrame(frame);
  newest_sent_ = std::max(newest_sent_, frame.images.frame_id);
  process_.SetCounter("frames.sent", static_cast<double>(++n_sent_));
  Enter(Phase::kSending);
  return options_.pace.lockstep ? WaitForPose(frame) : Sent::kAnswered;
}

/// "waiting for the pose of frame 0", with the reason if no vo_process has been running since the start.
std::string FrameSender::Awaited(const LoadedFrame& frame) const {
  std::string text = fmt::format("waiting for the pose of frame {}", frame.images.frame_id);
  if (turn_.has_reader()) return text;
  const bus::BusOptions& options = process_.bus().options();
  return fmt::format("{}: no vo_process is running on {}", text, bus::BusText(options.url, options.prefix));
}

FrameSender::Sent FrameSender::WaitForPose(const LoadedFrame& frame) {
  const int ticks_of_doubt = static_cast<int>(process_.bus().options().give_up_s) + kTicksBeyondTheBus;
  int ticks_to_resend = ticks_of_doubt;
  for (;;) {
    const Turn::Event event = turn_.WaitForPose(kWaitingTick);
    if (event == Turn::Event::kStopped) return Sent::kStopped;
    if (event == Turn::Event::kGoBack) return Sent::kGoBack;
    if (event == Turn::Event::kPose) {
      Enter(Phase::kSending);
      return Sent::kAnswered;
    }
    if (event == Turn::Event::kNewReader) {
      ticks_to_resend = kTicksBeforeResend;
    } else if (--ticks_to_resend == 0) {
      PublishFrame(frame);
      ticks_to_resend = ticks_of_doubt;
    }
    Enter(Phase::kWaiting, Joined(Awaited(frame), process_.bus().Problems()));
  }
}

bool FrameSender::WaitUntilDue(int64_t t_ns) {
  const int64_t due_ns = clock_.Due_ns(t_ns, Now_ns());
  if (!turn_.WaitUntil(Turn::Clock::time_point(std::chrono::nanoseconds(due_ns)))) return false;
  if (clock_.IsLate(due_ns, Now_ns())) process_.SetCounter("frames.late", static_cast<double>(++n_late_));
  return true;
}

void FrameSender::PassOver(const LoadedFrame& frame) {
  process_.SetCounter("frames.bad", static_cast<double>(++n_bad_));
  if (!options_.skip_bad) {
    PublishEnd();
    throw DatasetError(frame.error + " (--skip-bad skips unreadable frames)");
  }
  LogWarning("skipped: {}", frame.error);
}

/// Samples of an inertial sensor first: the reader needs them for the frame.
void FrameSender::PublishFrame(const LoadedFrame& frame) {
  if (source_->rig().imu) bus::PublishImu(process_.bus(), frame.imu_from_ns, frame.images.t_ns, frame.imu);
  publisher_.Publish(frame.images);
}

void FrameSender::PublishRig() { process_.bus().Publish(bus::kCamera, bus::ToMessage(source_->rig())); }

void FrameSender::PublishTruth(const LoadedFrame& frame) {
  if (source_->HasRecordedTruth()) {
    int64_t& n = frame.T_w_l ? n_true_ : n_without_truth_;
    process_.SetCounter(frame.T_w_l ? kTruthFrames : kTruthMissing, static_cast<double>(++n));
  }
  if (!frame.T_w_l) return;
  ground_truth_t message;
  message.header = {};
  message.header.t_ns = frame.images.t_ns;
  message.frame_id = frame.images.frame_id.value;
  message.T_w_l = bus::ToMessage(*frame.T_w_l);
  process_.bus().Publish(bus::kGroundTruth, message);
}

void FrameSender::PublishStream(const char* event, int64_t n_frames) {
  stream_t message;
  message.header = {};
  message.header.session = process_.bus().source().value;
  message.dataset = source_->name();
  message.event = event;
  message.pace = options_.pace.lockstep ? stream_pace::kLockstep : stream_pace::kRealtime;
  message.n_frames = n_frames;
  message.n_bad = n_bad_;
  process_.bus().Publish(bus::kStream, std::move(message));
}

}  // namespace plslam::stream
