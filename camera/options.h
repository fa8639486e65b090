// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"

namespace plslam::camera {

/// Which cameras are read, and how; the rest stands in the rig file.
struct CameraOptions {
  std::string rig;
  std::string pace = "realtime";
  bool exit = false;
  /// Go on behind this frame, "ID@T_NS" as its pose said, or "bus", the newest that a pose on the bus is of. Empty:
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
