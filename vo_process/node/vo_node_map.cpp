#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <memory>

#include "core/process/worker.h"
#include "plslam/relocalisation_t.hpp"
#include "vo_process/node/vo_node.h"

// How the map, and what loop_process says, come to a tracker, and who waits for them.

namespace plslam {
namespace {

constexpr std::chrono::milliseconds kMapTick(200);

/// Newest keyframe of the session that is in the map, as the session counts; -1: none.
int64_t NewestOf(int64_t session, const Map& map) {
  int64_t newest = -1;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.session == session) newest = std::max(newest, keyframe.session_keyframe_id);
  }
  return newest;
}

}  // namespace

/// To the map and to loop_process.
void VoNode::Listen() {
  map_ = std::make_unique<bus::MapSubscriber>(process_.bus(), [this](const MapUpdate& update) {
    // In lockstep only what loop_process has had its say about: the same at every run.
    if (lockstep_ && !update.settled) return;
    if (update.session == session_) {
      map_keyframe_id_ = update.session_keyframe_id;
    } else if (map_keyframe_id_ < 0) {
      map_keyframe_id_ = NewestOf(session_, map_->replica().map());
    }
    OnMap();
  });
  process_.bus().Subscribe<relocalisation_t>(bus::kRelocalisation,
                                             [this](const relocalisation_t& m) { OnRelocalisation(m); });
  process_.bus().Every(kMapTick, [this] {
    const double now_s = bus::NowS();
    const bool no_map = map_wait_.GiveUp(now_s);
    if (no_map) spdlog::warn("no mapping_process is heard of: odometry goes on by itself");
    const bool no_answer = answer_wait_.GiveUp(now_s);
    if (no_answer) spdlog::warn("no loop_process is heard of: a lost camera is not found in the map");
    if (no_map || no_answer) GoOn();
  });
}

void VoNode::OnMap() {
  const auto awaited = map_wait_.awaited();
  if (!awaited) {
    if (!lockstep_) AdoptMap(adopted_keyframe_id_ + 1);
    return GoOn();
  }
  if (!AdoptMap(*awaited)) return;
  map_wait_.End();
  GoOn();
}

void VoNode::AwaitMap(int64_t keyframe_id) {
  if (!map_ || !lockstep_ || keyframe_id == 0 || AdoptMap(keyframe_id - 1)) return;
  map_wait_.Begin(keyframe_id - 1, bus::NowS());
}

bool VoNode::AdoptMap(int64_t oldest_keyframe_id) {
  if (!odometry_ || map_keyframe_id_ < oldest_keyframe_id) return false;
  if (odometry_->Adopt(map_->replica().map(), session_, map_keyframe_id_)) adopted_keyframe_id_ = map_keyframe_id_;
  return true;
}

}  // namespace plslam
