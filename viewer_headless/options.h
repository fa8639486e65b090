#pragma once

#include <cstdint>
#include <string>

#include "core/config/fields.h"

namespace plslam {

/// Section `viewer` of the configuration.
struct ViewerOptions {
  std::string out = "out";
  int64_t overlay_every = 0;
  bool quiet = false;
};

template <class Visitor>
void VisitFields(Visitor& visit, ViewerOptions& o) {
  visit("out", o.out, "folder for trajectories, tables and pictures");
  visit("overlay_every", o.overlay_every, Bounds{0, 1e9},
        "a picture of the tracked features every N frames; 0: none");
  visit("quiet", o.quiet, "no progress line");
}

}  // namespace plslam
