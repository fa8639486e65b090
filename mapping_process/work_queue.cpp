#include "mapping_process/work_queue.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <utility>

namespace plslam {

void WorkQueue::Restore(const std::map<int64_t, int64_t>& newest_by_session, int64_t newest_session) {
  restored_ = inserted_ = arrived_ = newest_by_session;
  const auto newest = inserted_.find(newest_session);
  if (newest != inserted_.end()) newest_ = {newest_session, newest->second, false, true};
}

void WorkQueue::Add(const Keyframe& keyframe, double now_ms) {
  const auto [newest, first] = arrived_.try_emplace(keyframe.session, keyframe.keyframe_id);
  if (!first && keyframe.keyframe_id <= newest->second) return;
  newest->second = keyframe.keyframe_id;
  keyframes_[keyframe.source].push_back({keyframe, now_ms});
}

void WorkQueue::Add(const LoopClosure& closure) {
  if (!options_.enabled) return;
  const auto restored = restored_.find(closure.session);
  if (restored != restored_.end() && closure.session_keyframe_id <= restored->second) return;
  // Said again in the name of a loop_process that has died: one keyframe may have several answers, each of one map.
  const Answer answer{closure.session, closure.session_keyframe_id, closure.map_source, closure.map_version,
                      static_cast<int>(closure.kind)};
  if (answers_.insert(answer).second) closures_.push_back(closure);
}

std::optional<WorkQueue::Work> WorkQueue::Take(double now_s) {
  Work work;
  if (!saves_.empty() && newest_.settled) {
    work.kind = Work::Kind::kSave;
    work.path = std::move(saves_.front());
    saves_.pop_front();
    return work;
  }
  if (std::exchange(asked_, false)) {
    work.kind = Work::Kind::kPublishWhole;
    return work;
  }
  if (auto closure = TakeClosure(now_s)) return closure;
  if (!newest_.settled && !wait_.awaited()) {
    newest_.settled = true;
    work.kind = Work::Kind::kSettle;
    return work;
  }
  if (IsStateDue()) {
    inserted_since_state_ = 0;
    work.kind = Work::Kind::kKeepState;
    return work;
  }
  if (Next() == nullptr || (newest_.lockstep && !newest_.settled)) return std::nullopt;
  work.keyframes = TakeKeyframes();
  return work;
}

// Where all has been said about what is in the map: then what is said again after a crash can be told from what is new. A new
// session may mean that the tracker of the last one has died, and nobody else has its keyframes.
bool WorkQueue::IsStateDue() {
  if (state_every_ == 0 || inserted_since_state_ == 0 || !newest_.settled) return false;
  return inserted_since_state_ >= state_every_ ||
         (Next() != nullptr && !inserted_.contains(Next()->front().keyframe.session));
}

void WorkQueue::Inserted(const Keyframe& keyframe, int count, double now_s) {
  inserted_since_state_ += count;
  inserted_[keyframe.session] = keyframe.keyframe_id;
  newest_ = {keyframe.session, keyframe.keyframe_id, keyframe.lockstep, false};
  wait_.End();
  if (options_.enabled) wait_.Begin(keyframe.keyframe_id, now_s);
}

bool WorkQueue::IsInserted(const LoopClosure& closure) const {
  const auto session = inserted_.find(closure.session);
  return session != inserted_.end() && session->second >= closure.session_keyframe_id;
}

bool WorkQueue::IsAboutNewest(const LoopClosure& closure) const {
  return closure.session == newest_.session && closure.session_keyframe_id == newest_.keyframe_id;
}

std::optional<WorkQueue::Work> WorkQueue::TakeClosure(double now_s) {
  for (;;) {
    const auto found = std::find_if(closures_.begin(), closures_.end(),
                                    [this](const LoopClosure& closure) { return IsInserted(closure); });
    if (found == closures_.end()) return std::nullopt;
    Work work;
    work.kind = Work::Kind::kCorrect;
    work.closure = std::move(*found);
    closures_.erase(found);
    const bool settles = IsAboutNewest(work.closure) && !newest_.settled && !work.closure.more;
    // About a keyframe of lockstep that is settled already: said again by a loop_process that was started again.
    const bool again = newest_.lockstep && (newest_.settled || !IsAboutNewest(work.closure));
    if (again || (work.closure.kind == LoopClosure::Kind::kNone && !settles)) continue;
    work.settles = settles;
    if (settles) {
      newest_.settled = true;
      wait_.End();
    } else if (IsAboutNewest(work.closure)) {
      wait_.Begin(newest_.keyframe_id, now_s);
    }
    return work;
  }
}

size_t WorkQueue::n_keyframes() const {
  return std::transform_reduce(keyframes_.begin(), keyframes_.end(), size_t{0}, std::plus<>(),
                               [](const auto& of_publisher) { return of_publisher.second.size(); });
}

std::deque<WorkQueue::Arrived>* WorkQueue::Next() {
  std::deque<Arrived>* oldest = nullptr;
  for (auto& [publisher, keyframes] : keyframes_) {
    if (keyframes.empty()) continue;
    if (oldest == nullptr || keyframes.front().keyframe.t_ns < oldest->front().keyframe.t_ns) oldest = &keyframes;
  }
  return oldest;
}

std::vector<WorkQueue::Arrived> WorkQueue::TakeKeyframes() {
  std::vector<Arrived> taken;
  while (std::deque<Arrived>* next = Next()) {
    const bool lockstep = next->front().keyframe.lockstep;
    // An update names the newest keyframe of one session, whose tracker takes it over.
    const bool same = taken.empty() || next->front().keyframe.session == taken.front().keyframe.session;
    if (!same || (lockstep && !taken.empty())) break;
    taken.push_back(std::move(next->front()));
    next->pop_front();
    if (lockstep) break;
  }
  return taken;
}

}  // namespace plslam
