// SPDX-License-Identifier: BSD-3-Clause
#include "core/map/removed_poses.h"

#include <algorithm>
#include <utility>

namespace plslam {

void RemovedPoses::BeginVersion(int64_t version) {
  version_ = std::max(version_, version);
  while (!corrections_.empty() && corrections_.front().version < version_ - kKept) corrections_.pop_front();
}

SE3 RemovedPoses::CorrectionOf(KeyframeId id) const {
  const auto found = D_.find(id);
  return found == D_.end() ? SE3() : found->second;
}

void RemovedPoses::Move(const std::map<KeyframeId, SE3>& T_new_old) {
  Correction correction{version_, {}};
  for (const auto& [id, displacement] : T_new_old) {
    const SE3 before = CorrectionOf(id);
    correction.D_before[id] = before;
    D_[id] = displacement * before;
  }
  corrections_.push_back(std::move(correction));
}

void RemovedPoses::Add(const MapKeyframe& keyframe, KeyframeId carrier_id) {
  removed_[keyframe.id] = {version_,        keyframe.name.session,     keyframe.frame_id, keyframe.T_odom_kf,
                           keyframe.T_w_kf, CorrectionOf(keyframe.id), carrier_id,        CorrectionOf(carrier_id)};
  D_.erase(keyframe.id);
}

void RemovedPoses::Forget(KeyframeId id) {
  const auto returned = removed_.find(id);
  if (returned == removed_.end()) return;
  // Keyframes that it carries know it by this product.
  D_[id] = returned->second.D_kf;
  removed_.erase(returned);
}

void RemovedPoses::Forget(const std::set<KeyframeId>& ids) {
  for (auto& [id, removed] : removed_) {
    if (ids.contains(id)) continue;
    while (ids.contains(removed.carrier_id)) {
      const auto carrier = removed_.find(removed.carrier_id);
      if (carrier == removed_.end()) break;
      removed.D_carrier = removed.D_carrier * (carrier->second.D_kf.Inverse() * carrier->second.D_carrier);
      removed.carrier_id = carrier->second.carrier_id;
    }
  }
  std::erase_if(removed_, [&ids](const auto& entry) { return ids.contains(entry.first); });
}

void RemovedPoses::ReturnTo(int64_t version, const IdMap<KeyframeId, MapKeyframe>& keyframes) {
  for (const auto& [id, removed] : removed_) {
    if (removed.version > version) D_[id] = removed.D_kf;
  }
  std::erase_if(removed_, [version](const auto& entry) { return entry.second.version > version; });
  while (!corrections_.empty() && corrections_.back().version > version) {
    for (const auto& [id, before] : corrections_.back().D_before) D_[id] = before;
    corrections_.pop_back();
  }
  std::erase_if(D_, [&keyframes](const auto& entry) { return keyframes.Find(entry.first) == nullptr; });
  version_ = version;
}

std::vector<RemovedKeyframe> RemovedPoses::Keyframes() const {
  std::map<KeyframeId, SE3> D;  // of removed keyframes
  std::vector<RemovedKeyframe> keyframes;
  keyframes.reserve(removed_.size());
  for (const auto& [id, newest] : removed_) {
    std::vector<KeyframeId> chain;
    SE3 D_carrier;
    for (KeyframeId next = id;; next = removed_.at(next).carrier_id) {
      if (const auto known = D.find(next); known != D.end()) {
        D_carrier = known->second;
        break;
      }
      if (!removed_.contains(next)) {
        D_carrier = CorrectionOf(next);
        break;
      }
      chain.push_back(next);
    }
    for (auto link = chain.rbegin(); link != chain.rend(); ++link) {
      const Removed& removed = removed_.at(*link);
      D_carrier = D_carrier * (removed.D_carrier.Inverse() * removed.D_kf);
      D[*link] = D_carrier;
    }
    const SE3 T_w_kf = D.at(id) * (newest.D_kf.Inverse() * newest.T_w_kf);
    keyframes.push_back({id, newest.session, newest.frame_id, newest.T_odom_kf, T_w_kf});
  }
  return keyframes;
}

}  // namespace plslam
