// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <set>
#include <string>

#include "camera/camera_source.h"
#include "camera/options.h"
#include "core/process/process.h"
#include "core/stream/node/frame_sender.h"

namespace plslam::camera {

/// Publishes the quality of the frames in the status of a process: its counters, and a sentence for each defect when it
/// is first detected. Called on the thread that sends frames.
class HealthReport {
 public:
  explicit HealthReport(bus::Process& process) : process_(process) {}

  void OnFrame(const CaptureHealth& health, const Pairing& pairing);
  void OnOutage(const std::string& why);

 private:
  void Count(const CaptureHealth& health, const Pairing& pairing);
  void Warn(const std::string& what, const std::string& sentence);

  bus::Process& process_;
  std::set<std::string> warned_;
  bool is_out_ = false;
  int64_t outages_ = 0;
};

/// Brings the frames of cameras, or of files, onto the bus (FrameSender).
class CameraNode {
 public:
  /// Throws where rig file, pipeline and pace do not fit.
  CameraNode(bus::Process& process, const CameraOptions& options);

 private:
  HealthReport report_;
  stream::FrameSender sender_;
};

}  // namespace plslam::camera
