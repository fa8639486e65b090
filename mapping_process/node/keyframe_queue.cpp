// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/keyframe_queue.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

namespace plslam::mapping {

Keyframe KeyframeOf(const MapKeyframe& entry, const FeaturesView& features, const StereoCamera& camera,
                    const Map& map) {
  Keyframe keyframe;
  keyframe.camera = CameraOf(features, camera);
  keyframe.name = entry.name;
  keyframe.t_ns = entry.t_ns;
  keyframe.frame_id = entry.frame_id;
  const MapKeyframe* previous = map.FindKeyframe(entry.previous_id);
  if (previous != nullptr) keyframe.previous_keyframe_id = previous->name.number;
  keyframe.T_prevkf_kf = entry.T_prevkf_kf;
  keyframe.covariance = entry.relative_covariance;
  keyframe.T_odom_kf = entry.T_odom_kf;
  keyframe.up = entry.up;
  keyframe.state = 1;
  keyframe.SetFeatures(OwnFeatures(features));
  return keyframe;
}

void KeyframeQueue::Restore(const std::map<SessionId, int64_t>& newest_by_session) {
  for (const auto& [session, newest] : newest_by_session) sessions_[session].next = newest + 1;
}

bool KeyframeQueue::Add(const Keyframe& keyframe, double now_ms) {
  if (keyframe.name.number > kLast) return false;
  Session& session = sessions_[keyframe.name.session];
  if (keyframe.name.number < session.next) return false;
  if (!session.waiting.try_emplace(keyframe.name.number, Arrived{keyframe, now_ms}).second) return false;
  std::vector<SessionId>& published = published_[keyframe.source];
  if (std::find(published.begin(), published.end(), keyframe.name.session) == published.end())
    published.push_back(keyframe.name.session);
  return true;
}

void KeyframeQueue::Drop(SessionId session) {
  const auto found = sessions_.find(session);
  if (found != sessions_.end()) found->second.waiting.clear();
}

bool KeyframeQueue::IsReady(const Session& session, double now_ms) {
  const auto& [number, front] = *session.waiting.begin();
  return number == session.next || now_ms - std::max(front.received_ms, session.taken_ms) >= kPatience_ms;
}

/// Returns the sessions that wait for another one of the same publisher, ascending.
std::vector<SessionId> KeyframeQueue::Held() const {
  std::vector<SessionId> held;
  for (const auto& [publisher, published] : published_) {
    const auto waits = [this](SessionId session) { return !sessions_.at(session).waiting.empty(); };
    const auto first = std::find_if(published.begin(), published.end(), waits);
    if (first != published.end()) held.insert(held.end(), first + 1, published.end());
  }
  std::sort(held.begin(), held.end());
  return held;
}

std::optional<SessionId> KeyframeQueue::NextSession(double now_ms) const {
  const std::vector<SessionId> held = Held();
  std::optional<SessionId> next;
  std::optional<SessionId> next_of_held;
  bool all_held = true;
  const auto is_older = [this](SessionId session, const std::optional<SessionId>& other) {
    const auto t_ns = [this](SessionId of) { return sessions_.at(of).waiting.begin()->second.keyframe.t_ns; };
    return !other || t_ns(session) < t_ns(*other);
  };
  for (const auto& [id, session] : sessions_) {
    if (session.waiting.empty()) continue;
    const bool is_held = std::binary_search(held.begin(), held.end(), id);
    all_held = all_held && is_held;
    std::optional<SessionId>& candidate = is_held ? next_of_held : next;
    if (IsReady(session, now_ms) && is_older(id, candidate)) candidate = id;
  }
  // If publishers name sessions in contradictory orders, all are held: ignore the order then.
  return all_held ? next_of_held : next;
}

const Keyframe* KeyframeQueue::Next(double now_ms) const {
  const auto session = NextSession(now_ms);
  return session ? &sessions_.at(*session).waiting.begin()->second.keyframe : nullptr;
}

std::optional<KeyframeQueue::Arrived> KeyframeQueue::Take(double now_ms) {
  const auto id = NextSession(now_ms);
  if (!id) return std::nullopt;
  Session& session = sessions_.at(*id);
  auto front = session.waiting.extract(session.waiting.begin());
  Arrived taken = std::move(front.mapped());
  taken.missing = front.key() - session.next;
  session.next = front.key() + 1;
  session.taken_ms = now_ms;
  return taken;
}

size_t KeyframeQueue::size() const {
  return std::transform_reduce(sessions_.begin(), sessions_.end(), size_t{0}, std::plus<>(),
                               [](const auto& session) { return session.second.waiting.size(); });
}

}  // namespace plslam::mapping
