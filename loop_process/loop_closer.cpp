// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_closer.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/symmetric.h"
#include "loop_process/keyframe_memory.h"
#include "loop_process/loop_candidates.h"
#include "loop_process/loop_correction.h"
#include "loop_process/loop_verification.h"
#include "loop_process/relocaliser.h"

namespace plslam::loop {
namespace {

// Searches from the newest keyframe, which is the usual one.
const MapKeyframe* FindByName(const Map& map, const KeyframeName& name) {
  for (auto entry = map.keyframes().rbegin(); entry != map.keyframes().rend(); ++entry) {
    const MapKeyframe& keyframe = entry->second;
    if (keyframe.name.session != name.session) continue;
    if (keyframe.name == name) return &keyframe;
    if (keyframe.name.number < name.number) return nullptr;
  }
  return nullptr;
}

// Whether a third of the keyframes of a map have been removed. Their observations took part in its estimates; an adjustment of
// the remaining ones alone would lose what they contributed.
bool KnowsMoreThanItShows(const Map& map) {
  const auto& keyframes = map.keyframes();
  return !keyframes.empty() && 2 * keyframes.rbegin()->first.value >= 3 * static_cast<int64_t>(keyframes.size());
}

// Squared error of a loop, in its sigmas, below which the map has the measured relation already. Among known landmarks
// loops differ by up to a quarter of a sigma, after an unmapped way by half a sigma or more.
constexpr double kAgrees2 = 0.15;

bool Agrees(const Map& map, const LoopEdge& loop) {
  const SE3 T_old_kf =
      map.FindKeyframe(loop.old_keyframe_id)->T_w_kf.Inverse() * map.FindKeyframe(loop.keyframe_id)->T_w_kf;
  const double error2 = SquaredMahalanobis<6>((loop.T_old_kf.Inverse() * T_old_kf).Log(), loop.covariance);
  return error2 >= 0.0 && error2 < kAgrees2;
}

}  // namespace

LoopCloser::LoopCloser(const StereoCamera& camera, PlaceRecogniser places, const LoopOptions& options)
    : camera_(camera), options_(options), memory_(std::move(places)) {}

LoopClosure LoopCloser::Check(const Map& map, const KeyframeName& name) {
  LoopClosure closure;
  closure.keyframe = name;
  last_ = {};
  Follow(map);
  const MapKeyframe* keyframe = FindByName(map, name);
  if (keyframe == nullptr) return closure;
  closure.t_ns = keyframe->t_ns;
  if (!options_.enabled || !memory_.places().Has(keyframe->id)) return closure;
  last_ = FindLoop(map, memory_, camera_, options_, keyframe->id);
  if (!last_.best) return closure;
  const LoopEvidence& evidence = last_.evidence[*last_.best];
  auto poses = CloseLoop(map, evidence.edge, options_.correction);
  if (!poses) return closure;
  closure.kind = LoopClosure::Kind::kLoop;
  closure.more = options_.adjustment.enabled && !(KnowsMoreThanItShows(map) && Agrees(map, evidence.edge));
  closure.edges = {evidence.edge};
  closure.points = evidence.points;
  closure.lines = evidence.lines;
  closure.poses = std::move(*poses);
  closure.names = NamesIn(map, closure);
  closure.score = last_.candidates[*last_.best].score;
  return closure;
}

GlobalBundleProblem LoopCloser::MakeGlobalBundle(const Map& map, const LoopClosure& loop) const {
  GlobalBundleProblem problem = MakeGlobalBundleProblem(map, memory_.features(), camera_, options_.adjustment);
  problem.keyframe = loop.keyframe;
  problem.t_ns = loop.t_ns;
  return problem;
}

Relocalisation LoopCloser::Relocalise(const Map& map, const FeaturesView& features) const {
  return FindCamera(map, memory_, features, camera_, options_);
}

}  // namespace plslam::loop
