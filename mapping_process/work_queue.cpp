#include "mapping_process/work_queue.h"

#include <algorithm>
#include <utility>

namespace plslam {

void WorkQueue::Add(const LoopClosure& closure) {
  if (options_.enabled) closures_.push_back(closure);
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
  if (keyframes_.empty() || (newest_.lockstep && !newest_.settled)) return std::nullopt;
  work.keyframes = TakeKeyframes();
  return work;
}

void WorkQueue::Inserted(const Keyframe& keyframe, double now_s) {
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

std::vector<WorkQueue::Arrived> WorkQueue::TakeKeyframes() {
  std::vector<Arrived> taken;
  while (!keyframes_.empty()) {
    const bool lockstep = keyframes_.front().keyframe.lockstep;
    // An update names the newest keyframe of one session, whose tracker takes it over.
    const bool same = taken.empty() || keyframes_.front().keyframe.session == taken.front().keyframe.session;
    if (!same || (lockstep && !taken.empty())) break;
    taken.push_back(std::move(keyframes_.front()));
    keyframes_.pop_front();
    if (lockstep) break;
  }
  return taken;
}

}  // namespace plslam
