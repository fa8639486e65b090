// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include "core/bus/messages/frame_channel.h"
#include "core/datasets/dataset.h"
#include "core/process/process.h"
#include "player/node/frame_loader.h"
#include "player/node/turn.h"
#include "player/options.h"
#include "player/pacing.h"

namespace plslam {
class command_t;
}  // namespace plslam

namespace plslam::player {

/// Plays a dataset onto the bus: the rig at 1 Hz, and on a thread of its own the begin of the stream, true poses,
/// frames and the end of the stream.
///
/// In lockstep frame n + 1 goes out when a POSE of frame n has come back; without a reader it waits, and its status
/// says so. A vo_process that starts anew in between gets the pending frame again (the old one may have taken it with
/// it), so readers must expect a frame id twice. A frame that cannot be read ends the stream and the process, or is
/// counted.
///
/// Where a vo_process that was started again wants frames once more (the command "go_back"), lockstep goes back to
/// them.
///
/// Somebody may pause it: then no frame goes out that has not been out before.
///
/// A player that is started in the place of one that was killed goes on behind the frames that have been answered
/// (`resume_after`), with the same numbers and times.
class PlayerNode {
 public:
  /// Throws where the dataset cannot be opened.
  PlayerNode(bus::Process& process, const PlayerOptions& options);
  ~PlayerNode();

 private:
  void SendAll();
  bool SendRest();
  bool WaitForReaders(bool silent_too = false);
  bool IsGoneBack();
  bool MakeLoader(const std::optional<ResumePoint>& resume);
  void OnCommand(const command_t& command);
  void SetPaused(bool paused);
  std::optional<ResumePoint> WhereToResume();
  enum class Sent { kAnswered, kGoBack, kStopped };
  Sent Send(const LoadedFrame& frame);
  std::optional<Sent> WaitWhilePaused(int64_t frame_id);
  Sent WaitForPose(const LoadedFrame& frame);
  bool WaitUntilDue(int64_t t_ns);
  void PassOver(const LoadedFrame& frame);
  void PublishRig();
  void PublishTruth(const LoadedFrame& frame);
  void PublishStream(const char* event, int64_t n_frames);

  bus::Process& process_;
  const PlayerOptions options_;
  const Pace pace_;
  std::unique_ptr<Dataset> dataset_;
  const RigCalibration rig_;           // the dataset's, with the masks of the options
  std::optional<ResumePoint> resume_;  // where the options name it
  const PlayOrder order_;
  RealtimeClock clock_;
  bus::FramePublisher publisher_;
  std::mutex mutex_;  // of `loader_`, which the sending thread makes
  std::optional<FrameLoader> loader_;
  Turn turn_;
  int64_t n_sent_ = 0;
  int64_t newest_sent_ = -1;  ///< number of a frame
  int64_t n_bad_ = 0;
  int64_t n_late_ = 0;
  int64_t n_true_ = 0;
  int64_t n_without_truth_ = 0;
  bool running_ = false;
  std::thread sender_;
};

}  // namespace plslam::player
