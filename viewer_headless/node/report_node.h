// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/bus/messages/loop_channel.h"
#include "core/process/order_sender.h"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "viewer_headless/live/live_view.h"
#include "viewer_headless/node/heard_surfaces.h"
#include "viewer_headless/options.h"
#include "viewer_headless/report/report_recorder.h"

namespace plslam::viewer {

/// Collects the data of the report beside poses and map, writes `report.html`, serves the live page, and sends its
/// orders.
class ReportNode {
 public:
  /// The state of the run from which the report is made; it outlives this object and changes during the run.
  struct Sources {
    const Recorder* recorder = nullptr;
    const Map* map = nullptr;
    std::function<Eigen::Quaterniond()> q_l_c;
    std::function<void()> on_surfaces;  ///< called after a message of dense_process
  };

  /// Throws std::runtime_error if the live page is requested and cannot be served.
  ReportNode(bus::Bus& bus, const ViewerOptions& options, Sources sources);
  /// Returns after the watching pages have been notified of the end of the run, if it has ended.
  ~ReportNode();

  void OnStream(const stream_t& message);
  void OnStatus(const status_t& message);
  void OnMap(const MapUpdate& update);
  void SetCamera(const StereoCamera& camera);
  /// A new stream begins.
  void StartNewRun();
  /// Throws std::runtime_error.
  void Write();

  /// Whether a dense_process has not yet published all surfaces of the report.
  bool SurfacesMayCome() const { return surfaces_ && surfaces_->MayCome(); }

  /// Returns nullptr if no report is made.
  PictureStore* pictures() { return wanted_ ? &report_->pictures() : nullptr; }

 private:
  FrameId NewestFrame() const;
  /// The lag of a process in frames: for vo_process the frames sent after its newest pose; for mapping_process and
  /// loop_process, whose lag is independent, LagInFrames; -1 for others.
  int64_t Lag_frames(const status_t& message);
  std::string Json(const ReportSince& since) const;
  void ListenToSurfaces(bus::Bus& bus);
  void ShowSurfaces();
  void Serve(bus::Bus& bus);
  void CarryOutOrders();

  ViewerOptions options_;
  Sources sources_;
  std::optional<std::string> page_;
  bool wanted_;
  int64_t run_ = 0;
  /// Frames that the player had sent, at its last status, since the newest one with a pose.
  int64_t behind_ = 0;
  std::optional<StereoCamera> camera_;
  std::unique_ptr<ReportRecorder> report_;
  std::unique_ptr<bus::LoopClosureSubscriber> loops_;
  std::unique_ptr<HeardSurfaces> surfaces_;
  std::optional<bus::OrderSender> orders_;  ///< of the live page
  bool waits_for_order_ = false;
  std::unique_ptr<LiveView> live_;
};

}  // namespace plslam::viewer
