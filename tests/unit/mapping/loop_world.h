// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/ids/ids.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::test {

/// A closed passage of points and edges around a circle, of which a part is in view; and keyframes on the circle,
/// looking along it.
FeatureWorld MakeRing(double radius_m, int points, int lines, uint64_t seed);
std::vector<SE3> RingPath(double radius_m, double step_m, int n);

/// Names the landmarks of the map that the features show, as a tracker would that was given them: those that the
/// session created.
void GiveMapIds(const Map& map, SessionId session, Keyframe& keyframe);

/// Newest keyframe of the map, and the first one that is nearest in truth.
struct Revisit {
  KeyframeId old_keyframe_id = -1;
  KeyframeId keyframe_id = -1;
};
Revisit RevisitOf(const Map& map, const std::vector<SE3>& T_w_c);

/// Poses as a tracker with a steady drift would have them: each step a little wrong in the same way.
LoopClosure Drift(const Map& map);

/// Returns the closure that loop_process would publish: the true relative pose of both keyframes, the error distributed
/// over the steps between them (least squares, equal weights), and the landmarks of both that are the same in the
/// world.
LoopClosure CloseByTruth(const Map& map, const Revisit& revisit, const std::vector<SE3>& T_w_c);

/// Returns the true pose of every keyframe of the map, as global bundle adjustment would give it.
LoopClosure AdjustByTruth(const Map& map, const std::vector<SE3>& T_w_c);

/// Landmarks beyond the first of the same descriptor.
int Duplicates(const Map& map);

/// Root mean square of the distances between points and where their keyframes see them in the left image, px.
double Reprojection_px(const Map& map, const std::vector<Keyframe>& keyframes);

}  // namespace plslam::test
