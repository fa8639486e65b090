// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/bus/messages/frame_channel.h"
#include "core/bus/messages/map_channel.h"
#include "core/bus/run_loop.h"
#include "core/geometry/rectification.h"
#include "core/process/process.h"
#include "core/run/node/run_end.h"
#include "core/run/recorder.h"
#include "plslam/command_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/run_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "viewer_headless/node/heard_streams.h"
#include "viewer_headless/node/picture_node.h"
#include "viewer_headless/node/report_node.h"
#include "viewer_headless/options.h"
#include "viewer_headless/result_folder.h"
#include "viewer_headless/terminal_line.h"

namespace plslam::viewer {

/// Listens to a run, shows a progress line on a terminal, and writes the files of docs/viewer.md when the run is over
/// (`RunEnd`; state "finished"); `Files` are its states. A requested output that cannot be delivered makes the state
/// "failed", with the reason, and exit code 1 at the end. No other process depends on it: it only reads ordered channels
/// from their histories.
class ViewerNode {
 public:
  using Earlier = ResultFolder::Earlier;

  /// Throws std::runtime_error where ResultFolder does.
  ViewerNode(bus::Process& process, const ViewerOptions& options, Earlier earlier = Earlier::kKeep);
  /// Writes the results that are not yet written. Reports undelivered outputs once more at the end.
  ~ViewerNode();
  ViewerNode(const ViewerNode&) = delete;
  ViewerNode& operator=(const ViewerNode&) = delete;

 private:
  /// The results in the folder, and what ends each state.
  enum class Files {
    kNone,       ///< until a message about a run arrives
    kUnwritten,  ///< until the run is over, or this process is stopped
    kWritten,    ///< until another message arrives (kOutdated), or another stream begins (kNone)
    kOutdated,   ///< until they are written again, as from kUnwritten
  };

  void Subscribe();
  void OnCamera(const RigCalibration& rig);
  void OnStream(const stream_t& message);
  void OnPose(const pose_t& message);
  void OnStatus(const status_t& message);
  void OnCommand(const command_t& message);
  void OnMap(const MapUpdate& update);
  void OnTick();

  /// A message about the run has arrived.
  void OnNews();
  bool HasUnwritten() const { return files_ == Files::kUnwritten || files_ == Files::kOutdated; }
  bool HasWritten() const { return files_ == Files::kWritten || files_ == Files::kOutdated; }
  void BeginRun();
  void StartNewRun();
  Eigen::Quaterniond q_l_c() const;
  bool HasPlayed() const;
  bool StopsBeforeTheRig() const;
  bool RunIsOver() const;
  /// `ended`: the run is over; else it is stopped early.
  void Write(bool ended);
  std::vector<std::string> WriteFiles();
  void SetFailures(const std::vector<std::string>& failures);
  void Reject();
  void ShowProgress(bool last);

  bus::Process& process_;
  ViewerOptions options_;
  ResultFolder folder_;
  Recorder recorder_;
  std::unique_ptr<bus::MapSubscriber> map_;
  /// Rotation from the rectified left image (c) to the calibrated one (l), when the camera is known.
  std::optional<Eigen::Quaterniond> q_l_c_;
  std::unique_ptr<ReportNode> report_;
  std::unique_ptr<PictureNode> pictures_;
  std::optional<bus::CameraSubscriber> camera_;
  HeardStreams streams_;
  RunEnd end_;
  Files files_ = Files::kNone;
  const double began_s_ = bus::NowS();
  /// One sentence about the outputs that could not be delivered, of this stream and of an earlier one. Empty if there
  /// are none.
  std::string failure_, failure_before_;
  int64_t rejected_ = 0;
  TerminalLine terminal_;
};

}  // namespace plslam::viewer
