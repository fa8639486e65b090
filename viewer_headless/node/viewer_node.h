// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/bus/run_loop.h"
#include "core/files/folder_lock.h"
#include "core/geometry/rectification.h"
#include "core/process/process.h"
#include "core/run/recorder.h"
#include "plslam/command_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "viewer_headless/node/picture_node.h"
#include "viewer_headless/node/report_node.h"
#include "viewer_headless/options.h"

namespace plslam::viewer {

/// Listens to a run, shows a progress line on a terminal, and writes the files of docs/viewer.md when the stream has
/// ended, the camera and every pose have arrived, in lockstep every picture, and the map contains the last keyframe
/// (state "finished"); it writes them again when it is stopped and something arrived after that. A requested output
/// that cannot be delivered makes the state "failed", with the reason, and exit code 1 at the end. No other process
/// depends on it: it only reads ordered channels from their histories.
class ViewerNode {
 public:
  /// Treatment of results of an earlier run in the output folder: the viewer does not start; removes them when its own
  /// run begins; or leaves that to the launcher.
  enum class Earlier { kRefuse, kReplace, kKeep };

  /// Throws std::runtime_error if the output folder cannot be written, another process has it (FolderLock), or it has
  /// results (`kRefuse`).
  ViewerNode(bus::Process& process, const ViewerOptions& options, Earlier earlier = Earlier::kKeep);
  /// Writes the results that are not yet written. Reports undelivered outputs once more at the end.
  ~ViewerNode();
  ViewerNode(const ViewerNode&) = delete;
  ViewerNode& operator=(const ViewerNode&) = delete;

 private:
  void Subscribe();
  void OnCamera(const RigCalibration& rig);
  void OnStream(const stream_t& message);
  void OnPose(const pose_t& message);
  void OnStatus(const status_t& message);
  void OnCommand(const command_t& message);
  void OnMap(const MapUpdate& update);
  void OnTick();

  void BeginRun();
  void StartNewRun();
  Eigen::Quaterniond q_l_c() const;
  bool HasPlayed() const;
  bool StopsBeforeTheRig() const;
  void RemoveEarlier();
  bool RunIsOver() const;
  bool MapIsComplete() const;
  bool ExpectsPictures() const;
  /// `ended`: the run is over; else it is stopped early.
  void Write(bool ended);
  std::vector<std::string> WriteFiles();
  void SetFailures(const std::vector<std::string>& failures);
  void Reject();
  void ShowProgress(bool last);
  double FramesPerSecond();

  bus::Process& process_;
  ViewerOptions options_;
  Earlier earlier_;
  std::optional<FolderLock> lock_;
  Recorder recorder_;
  std::unique_ptr<bus::MapSubscriber> map_;
  /// Rotation from the rectified left image (c) to the calibrated one (l), when the camera is known.
  std::optional<Eigen::Quaterniond> q_l_c_;
  std::unique_ptr<ReportNode> report_;
  std::unique_ptr<PictureNode> pictures_;
  std::optional<bus::CameraSubscriber> camera_;
  int64_t announced_frames_ = -1;
  /// Players that have begun or resumed a stream, and whether every frame of the newest stream is awaited.
  std::set<int64_t> streams_;
  bool lockstep_ = false;
  bool vo_finished_ = false;
  bool mapping_heard_ = false;
  /// Whether a message has arrived since the files were written, and ticks since the last message.
  bool dirty_ = false;
  int quiet_ticks_ = 0;
  bool written_ = false;
  /// One sentence about the outputs that could not be delivered, of this stream and of an earlier one. Empty if there
  /// are none.
  bool replaces_ = false;  ///< earlier results are to be removed
  const double began_s_ = bus::NowS();
  std::string failure_, failure_before_;
  int64_t rejected_ = 0;
  bool on_terminal_;
  /// (seconds, frames) of the last ticks, for the rate.
  std::deque<std::pair<double, int64_t>> history_;
};

}  // namespace plslam::viewer
