// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "core/bus/messages/frame_channel.h"
#include "core/process/process.h"
#include "core/stream/frame_source.h"
#include "core/stream/node/turn.h"
#include "core/stream/pacing.h"

namespace plslam {
class command_t;
}  // namespace plslam

namespace plslam::stream {

struct SenderOptions {
  Pace pace;
  /// Pass over frames that cannot be read.
  bool skip_bad = false;
  /// End the process when all is sent and acknowledged.
  bool exit = false;
  /// Resume after this frame ("ID@T_NS"), or after the newest frame that has a pose on the bus (`kResumeFromBus`).
  std::string resume_after;
  /// Send no new frame before a command to resume.
  bool paused = false;
};

/// Sends the frames of a source to the bus: the rig at 1 Hz, and on its own thread the begin of the stream, true poses,
/// frames and the end of the stream.
///
/// In lockstep, frame n + 1 is sent after a POSE of frame n has arrived; without a reader the sender waits, and the
/// status of the process says so. A vo_process that restarts in between gets the pending frame again (the previous one
/// may have taken it), so readers must expect repeated frame ids. An unreadable frame ends the stream and the process,
/// or is counted.
///
/// A restarted vo_process may request frames again (the command "go_back"); lockstep then goes back to them.
///
/// While the sender is paused, it sends no frame that has not been sent before. Frames of live cameras are lost during
/// a pause.
///
/// A process that replaces one that was killed resumes after the answered frames (`resume_after`), with continuing ids.
class FrameSender {
 public:
  /// Throws std::runtime_error if the resume point cannot be parsed. Afterwards the process is ready.
  FrameSender(bus::Process& process, std::unique_ptr<FrameSource> source, const SenderOptions& options);
  ~FrameSender();

 private:
  /// The state of the process, and what ends it.
  enum class Phase {
    kReady,     ///< until a frame is sent
    kSending,   ///< until the readers have everything, or a pose does not arrive within a second
    kWaiting,   ///< running, with the reason why: until the pose arrives, or other frames are requested
    kFinished,  ///< until frames are requested again
  };

  void Enter(Phase phase, const std::string& reason = "");
  void SendAll();
  bool SendRest();
  std::optional<LoadedFrame> NextFrame();
  bool WaitForReaders(bool silent_too = false);
  bool IsRewound();
  bool Begin(const std::optional<ResumePoint>& resume);
  void OnCommand(const command_t& command);
  void OnGoBack(const command_t& command);
  void SetPaused(bool paused);
  std::optional<ResumePoint> WhereToResume();
  enum class Sent { kAnswered, kGoBack, kStopped };
  Sent Send(const LoadedFrame& frame);
  std::optional<Sent> WaitWhilePaused(FrameId frame_id);
  std::string Awaited(const LoadedFrame& frame) const;
  Sent WaitForPose(const LoadedFrame& frame);
  bool WaitUntilDue(int64_t t_ns);
  void PassOver(const LoadedFrame& frame);
  void PublishFrame(const LoadedFrame& frame);
  void PublishRig();
  void PublishTruth(const LoadedFrame& frame);
  void PublishEnd();
  void PublishStream(const char* event, int64_t n_frames);

  bus::Process& process_;
  const SenderOptions options_;
  const std::unique_ptr<FrameSource> source_;
  std::optional<ResumePoint> resume_;  // where the options name it
  RealtimeClock clock_;
  bus::FramePublisher publisher_;
  Turn turn_;
  int64_t n_sent_ = 0;
  FrameId newest_sent_;
  int64_t n_bad_ = 0;
  int64_t n_late_ = 0;
  int64_t n_true_ = 0;
  int64_t n_without_truth_ = 0;
  Phase phase_ = Phase::kReady;
  std::thread sender_;
};

}  // namespace plslam::stream
