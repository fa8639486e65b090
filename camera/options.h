// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"
#include "core/run/process_names.h"

namespace plslam::camera {

/// The cameras to read, and the pace; all other settings are in the rig file.
struct CameraOptions {
  std::string rig;
  std::string pace = stream_pace::kRealtime;
  bool exit = false;
  /// Resume after this frame, "ID@T_NS" as in its pose, or "bus", the newest frame that has a pose on the bus. Empty:
  /// from the start.
  std::string resume_after;
  bool paused = false;
};

template <class Visitor>
void VisitFields(Visitor& visit, CameraOptions& o) {
  visit("rig", o.rig, "rig file: camera.yaml with a source");
  visit("pace", o.pace, "realtime, or lockstep (files only)");
  visit("exit", o.exit, "as player.exit");
  visit("resume_after", o.resume_after, "as player.resume_after");
  visit("paused", o.paused, "as player.paused");
}

}  // namespace plslam::camera
