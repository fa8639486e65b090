// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/node/work_queue.h"

#include <algorithm>
#include <utility>

#include "core/run/process_names.h"

namespace plslam::mapping {
namespace {

constexpr double kMsPerS = 1000.0;

size_t PartsOf(const LoopClosure& closure) {
  return 1 + closure.edges.size() + closure.points.size() + closure.lines.size() + closure.poses.size() +
         closure.names.size();
}

}  // namespace

void WorkQueue::Restore(const std::map<SessionId, int64_t>& newest_by_session, SessionId newest_session) {
  restored_ = inserted_ = newest_by_session;
  keyframes_.Restore(newest_by_session);
  const auto newest = inserted_.find(newest_session);
  if (newest != inserted_.end()) newest_ = {{newest_session, newest->second}, false, true, {}};
}

void WorkQueue::Restore(const std::map<SessionId, int64_t>& newest_by_session, const Newest& newest, double now_s) {
  Restore(newest_by_session, newest.keyframe.session);
  if (newest.committed) return;
  newest_ = newest;
  --restored_[newest.keyframe.session];
  if (awaits_loops_) wait_.Begin(newest.keyframe.number, now_s);
}

bool WorkQueue::IsLockstep(double now_s) const {
  const Keyframe* next = keyframes_.Next(kMsPerS * now_s);
  return newest_.lockstep || (next != nullptr && next->lockstep);
}

void WorkQueue::AddOfNextMap(const Keyframe& keyframe, double now_ms) {
  if (!of_next_map_.empty()) {
    const MapId& next = of_next_map_.front().keyframe.map_id;
    if (next.Supersedes(keyframe.map_id)) return;
    if (keyframe.map_id.Supersedes(next)) of_next_map_.clear();
  }
  of_next_map_.push_back({keyframe, now_ms, 0});
}

void WorkQueue::Reset(const MapId& map_id, const std::map<SessionId, int64_t>& newest_by_session,
                      SessionId newest_session) {
  WorkQueue next(awaits_loops_, wait_.wait_s(), state_every_);
  next.wait_ = wait_;
  next.wait_.End();
  next.orders_ = std::move(orders_);
  next.caught_up_ = true;
  next.Restore(newest_by_session, newest_session);
  for (Arrived& arrived : of_next_map_) {
    if (arrived.keyframe.map_id.Matches(map_id)) next.Add(arrived.keyframe, arrived.received_ms);
    if (arrived.keyframe.map_id.Supersedes(map_id)) next.of_next_map_.push_back(std::move(arrived));
  }
  *this = std::move(next);
}

void WorkQueue::Add(const LoopClosure& closure) {
  // loop_process checks no keyframe until the map has answered its loop.
  if (!awaits_loops_ && closure.kind != LoopClosure::Kind::kLoop) return;
  const auto restored = restored_.find(closure.keyframe.session);
  if (restored != restored_.end() && closure.keyframe.number <= restored->second) return;
  // Resent for a loop_process that has exited: one keyframe may have several closures, each of another map version.
  if (!answers_.insert(AnswerOf(closure)).second) return;
  closures_.push_back(closure);
  n_parts_ += PartsOf(closure);
  while (n_parts_ > kMostParts) DropOldest();
}

WorkQueue::Answer WorkQueue::AnswerOf(const LoopClosure& closure) {
  return {closure.keyframe, closure.map_version, closure.kind};
}

/// Forgets a closure that changes nothing if it is resent, and the oldest of the others.
void WorkQueue::ForgetTaken(const LoopClosure& closure) {
  if (closure.kind == LoopClosure::Kind::kNone) {
    answers_.erase(AnswerOf(closure));
    return;
  }
  taken_.push_back(AnswerOf(closure));
  if (taken_.size() <= kMostTaken) return;
  answers_.erase(taken_.front());
  taken_.pop_front();
}

/// Drops the oldest closure whose keyframe has not arrived; it may be resent.
void WorkQueue::DropOldest() {
  auto oldest = std::find_if(closures_.begin(), closures_.end(),
                             [this](const LoopClosure& closure) { return !IsInserted(closure); });
  if (oldest == closures_.end()) oldest = closures_.begin();
  n_parts_ -= PartsOf(*oldest);
  answers_.erase(AnswerOf(*oldest));
  closures_.erase(oldest);
}

std::optional<WorkQueue::Work> WorkQueue::Take(double now_s) {
  Work work;
  if (!of_next_map_.empty()) {
    work.kind = Work::Kind::kBeginMap;
    work.map_id = of_next_map_.front().keyframe.map_id;
    return work;
  }
  caught_up_ = caught_up_ || keyframes_.size() == 0;
  const bool saves = !orders_.empty() && orders_.front().verb == command_verb::kSave;
  const bool waits = saves || (!orders_.empty() && orders_.front().verb == command_verb::kLocalise);
  if (!orders_.empty() && (!waits || (newest_.committed && (caught_up_ || !saves)))) {
    work.kind = Work::Kind::kOrder;
    work.order = std::move(orders_.front());
    orders_.pop_front();
    // Saving ends recent-landmark culling, so an older state no longer applies.
    saved_since_state_ = saved_since_state_ || saves;
    return work;
  }
  if (std::exchange(asked_, false)) {
    work.kind = Work::Kind::kPublishWhole;
    return work;
  }
  if (auto closure = TakeClosure(now_s)) return closure;
  if (!newest_.committed && !wait_.awaited()) {
    newest_.committed = true;
    work.kind = Work::Kind::kCommit;
    return work;
  }
  if (TakeState(now_s)) {
    work.kind = Work::Kind::kKeepState;
    return work;
  }
  if (newest_.lockstep && !newest_.committed) return std::nullopt;
  work.keyframes = TakeKeyframes(now_s);
  if (work.keyframes.empty()) return std::nullopt;
  return work;
}

bool WorkQueue::TakeState(double now_s) {
  if (!IsStateDue(now_s)) return false;
  inserted_since_state_ = 0;
  saved_since_state_ = false;
  return true;
}

// A state is written when all keyframes in it are committed: messages resent after a crash can then be separated from
// new ones. A new session, or another publisher of a known one, may follow the exit of a tracker, whose keyframes no
// other process has.
bool WorkQueue::IsStateDue(double now_s) const {
  if (state_every_ == 0 || !newest_.committed) return false;
  if (saved_since_state_) return true;
  if (inserted_since_state_ == 0) return false;
  if (inserted_since_state_ >= state_every_) return true;
  const Keyframe* next = keyframes_.Next(kMsPerS * now_s);
  if (next == nullptr) return false;
  const auto publisher = publishers_.find(next->name.session);
  return !inserted_.contains(next->name.session) ||
         (publisher != publishers_.end() && publisher->second != next->source);
}

void WorkQueue::Inserted(const Keyframe& keyframe, int count, double now_s) {
  inserted_since_state_ += count;
  inserted_[keyframe.name.session] = keyframe.name.number;
  publishers_[keyframe.name.session] = keyframe.source;
  newest_ = {keyframe.name, keyframe.lockstep, false, {}};
  wait_.End();
  if (awaits_loops_) wait_.Begin(keyframe.name.number, now_s);
}

bool WorkQueue::Refused() {
  wait_.End();
  return !std::exchange(newest_.committed, true);
}

bool WorkQueue::IsInserted(const LoopClosure& closure) const {
  const auto session = inserted_.find(closure.keyframe.session);
  return session != inserted_.end() && session->second >= closure.keyframe.number;
}

bool WorkQueue::IsAboutNewest(const LoopClosure& closure) const { return closure.keyframe == newest_.keyframe; }

std::optional<WorkQueue::Work> WorkQueue::TakeClosure(double now_s) {
  for (;;) {
    const auto found = std::find_if(closures_.begin(), closures_.end(),
                                    [this](const LoopClosure& closure) { return IsInserted(closure); });
    if (found == closures_.end()) return std::nullopt;
    Work work;
    work.kind = Work::Kind::kCorrect;
    n_parts_ -= PartsOf(*found);
    work.closure = std::move(*found);
    work.lockstep = newest_.lockstep;
    closures_.erase(found);
    ForgetTaken(work.closure);
    if (!awaits_loops_) {
      work.kind = Work::Kind::kAnswer;
      return work;
    }
    const bool commits = IsAboutNewest(work.closure) && !newest_.committed && !work.closure.more;
    // In lockstep there is one closure of each kind about a keyframe until it is committed. More arrive if loop_process
    // was restarted, or checked the keyframe again for a restarted mapping_process.
    const bool again = newest_.lockstep && (newest_.committed || !IsAboutNewest(work.closure) ||
                                            !newest_.taken.insert(work.closure.kind).second);
    if (again && work.closure.kind == LoopClosure::Kind::kLoop) {
      work.kind = Work::Kind::kAnswer;
      work.accepted = IsAboutNewest(work.closure) && !newest_.committed;
      return work;
    }
    if (again || (work.closure.kind == LoopClosure::Kind::kNone && !commits)) continue;
    work.commits = commits;
    if (commits) {
      newest_.committed = true;
      wait_.End();
    } else if (IsAboutNewest(work.closure)) {
      wait_.Begin(newest_.keyframe.number, now_s);
    }
    return work;
  }
}

std::vector<WorkQueue::Arrived> WorkQueue::TakeKeyframes(double now_s) {
  const double now_ms = kMsPerS * now_s;
  std::vector<Arrived> taken;
  while (const Keyframe* next = keyframes_.Next(now_ms)) {
    const bool lockstep = next->lockstep;
    // An update names the newest keyframe of one session, for its tracker.
    const bool same = taken.empty() || next->name.session == taken.front().keyframe.name.session;
    if (!same || (lockstep && !taken.empty())) break;
    taken.push_back(*keyframes_.Take(now_ms));
    if (lockstep) break;
  }
  return taken;
}

}  // namespace plslam::mapping
