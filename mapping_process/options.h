// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "core/config/fields.h"
#include "core/localisation/options.h"
#include "core/optim/bundle/options.h"

namespace plslam::mapping {

/// Insertion of a keyframe into the map (PL-SLAM §V.A).
struct InsertionOptions {
  /// Radius of the search for duplicates in neighbours.
  double fuse_radius_px = 4.0;
  /// Keyframes whose landmarks form the local map.
  int local_keyframes = 15;
  /// Neighbours in which new landmarks are searched.
  int fuse_keyframes = 5;
  /// Largest relative sigma of a disparity for a new landmark.
  double max_relative_depth_sigma = 0.3;
  /// Least angle between the planes of two views to triangulate a segment.
  double min_plane_angle_deg = 2.0;
};

/// Local bundle adjustment window (PL-SLAM §V.B).
struct WindowOptions {
  int keyframes = 5;
  int fixed_keyframes = 6;
  /// Points that are adjusted: those observed by most keyframes.
  int max_points = 600;
  /// The same of lines.
  int max_lines = 200;
  /// Observations of the adjusted points, at most one for each keyframe of the window; fewer points if exceeded.
  int max_point_observations = 4000;
  /// The same of lines.
  int max_line_observations = 1300;
  /// Landmarks that a neighbour must share with the new keyframe.
  int min_shared = 15;
  /// Sigma of the tracker's motion between keyframes, relative to the published one.
  double relative_sigma = 1.0;
};

/// Culling of landmarks and keyframes.
struct CullingOptions {
  /// Keyframes after which a new landmark is checked.
  int recent_keyframes = 3;
  int min_observations = 3;
  double redundant_share = 0.9;
  /// Other keyframes that must see a landmark for it to count as redundant.
  int redundant_observations = 5;
};

/// Use of closures of loop_process.
struct LoopUseOptions {
  bool enabled = true;
};

/// All options of mapping_process.
struct MappingOptions {
  InsertionOptions insertion;
  LocalisationOptions localisation;
  WindowOptions window;
  BundleOptions bundle;
  CullingOptions culling;
  LoopUseOptions loops;
  std::string map_file;
  bool localise_only = false;
  /// Maximum number of keyframes of the map; 0: no limit.
  int max_keyframes = 0;
  /// File with the state, written periodically, to continue exactly after a crash. Empty: rebuild the map from the
  /// history.
  std::string state_file;
  int state_every = 100;
};

template <class Visitor>
void VisitFields(Visitor& visit, WindowOptions& o) {
  visit("keyframes", o.keyframes, Bounds{2, 1000}, "adjusted keyframes: the new one and its neighbours");
  visit("fixed_keyframes", o.fixed_keyframes, Bounds{1, 1000}, "constant keyframes that observe the same landmarks");
}

template <class Visitor>
void VisitFields(Visitor& visit, CullingOptions& o) {
  visit("min_observations", o.min_observations, Bounds{1, 1000},
        "keyframes that must observe a landmark until recent-landmark culling ends");
  visit("redundant_share", o.redundant_share, Bounds{0.1, 1.01},
        "a keyframe is removed when others observe this share of its landmarks; above 1: never");
}

template <class Visitor>
void VisitFields(Visitor& visit, LoopUseOptions& o) {
  visit("enabled", o.enabled, "apply corrections by loop_process");
}

template <class Visitor>
void VisitFields(Visitor& visit, MappingOptions& o) {
  visit("window", o.window, "window of the local bundle adjustment");
  visit("bundle", o.bundle, "bundle adjustment");
  visit("culling", o.culling, "removal of landmarks and keyframes");
  visit("loops", o.loops, "corrections by loop_process");
  visit("map_file", o.map_file, "saved map to continue; empty: none");
  visit("localise_only", o.localise_only, "localise in a fixed map: insert no keyframes");
  visit("max_keyframes", o.max_keyframes, Bounds{0, 10000000},
        "largest number of keyframes (three always stay); above it those are removed that show nothing new; 0: no "
        "limit");
  visit("state_file", o.state_file, "file of the process state, read after a crash; empty: none");
  visit(
      "state_every", o.state_every, Bounds{1, 1000000},
      "the state is written after this many keyframes, before each new session, and before another tracker continues "
      "a session");
}

}  // namespace plslam::mapping
