// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/config/fields.h"

namespace plslam::viewer {

/// Section `viewer` of the configuration.
struct ViewerOptions {
  std::string out = "out";
  int64_t overlay_every = 0;
  bool quiet = false;
  bool report = true;
  int64_t report_pictures = 240;
  int64_t serve = 0;
  std::string video;
};

template <class Visitor>
void VisitFields(Visitor& visit, ViewerOptions& o) {
  visit("out", o.out, "folder for trajectories, tables and pictures");
  visit("overlay_every", o.overlay_every, Bounds{0, 1e9},
        "a picture of the tracked features every N frames; 0: none");
  visit("quiet", o.quiet, "no progress line");
  visit("report", o.report, "write report.html: the run as a page for any browser");
  visit("report_pictures", o.report_pictures, Bounds{0, 100'000},
        "largest number of pictures of frames in the report");
  visit("serve", o.serve, Bounds{0, 65535}, "port of 127.0.0.1 for a live page of the run; 0: none");
  visit("video", o.video, "film of the run: an MP4 file, or a folder for numbered pictures; empty: none");
}

}  // namespace plslam::viewer
