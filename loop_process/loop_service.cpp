// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/loop_service.h"

#include <algorithm>
#include <utility>

#include "core/files/shared_file.h"

namespace plslam::loop {

PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options) {
  return {Vocabulary::Load(FindSharedFile(files.points)), Vocabulary::Load(FindSharedFile(files.lines)), options};
}

namespace {

constexpr int64_t kNone = -1;

int64_t Newest(const std::map<SessionId, int64_t>& by_session, SessionId session) {
  const auto found = by_session.find(session);
  return found == by_session.end() ? kNone : found->second;
}

// Copies what identifies a closure, without edges and poses.
LoopClosure HeadOf(const LoopClosure& closure) {
  LoopClosure head;
  head.more = closure.more;
  head.keyframe = closure.keyframe;
  head.t_ns = closure.t_ns;
  head.map_version = closure.map_version;
  return head;
}

}  // namespace

LoopService::Output LoopService::OnKeyframe(const Keyframe& keyframe) {
  Output output;
  if (keyframe.lockstep) lockstep_[keyframe.name.session] = {keyframe.source, now_ms_()};
  // Republished for a tracker that has exited, or by a restarted mapping_process.
  if (!closer_.AddKeyframe(keyframe)) return output;
  missing_.OnArrival(keyframe.name, now_ms_());
  return OnTick();
}

LoopService::Output LoopService::OnTick() {
  Output output;
  RequestMissing(output);
  CheckDueKeyframes(output);
  AnswerDueKeyframes(output);
  return output;
}

void LoopService::OnAdjusted(const LoopClosure& adjustment) {
  const bool is_last = adjusting_ && adjusting_->keyframe == adjustment.keyframe;
  if (is_last) adjusting_.reset();
}

void LoopService::OnSignOfLife(SourceId source) {
  for (auto& [id, session] : lockstep_) {
    if (session.source == source) session.heard_ms = now_ms_();
  }
}

LoopService::Output LoopService::OnUpdate(const MapUpdate& update) {
  Output output;
  if (follower_.Apply(update) != MapStep::kNext) return output;
  if (follower_.change() == MapFollower::Change::kReplaced) {
    output.ends_adjustment = true;
    requests_.clear();
    closer_.ForgetSessions();
  }
  if (follower_.change() != MapFollower::Change::kContinued) {
    checked_.clear();
    due_.clear();
    unanswered_.reset();
    unadjusted_.reset();
    adjusting_.reset();
  }
  // A check may never come, and features of keyframes that have left the map must not accumulate.
  closer_.Follow(follower_.map(), follower_.change() == MapFollower::Change::kContinued);
  const auto has_features = [this](const KeyframeName& keyframe) { return closer_.Contains(keyframe); };
  if (update.IsWhole()) {
    missing_.Begin(follower_.map(), has_features, now_ms_());
  } else {
    missing_.Follow(follower_.map(), has_features);
  }
  Follow(update, output);
  CheckDueKeyframes(output);
  AnswerDueKeyframes(output);
  return output;
}

LoopService::Output LoopService::OnRequest(const Keyframe& frame) {
  Output output;
  // A tracker sends a second request only after it has given up the first.
  std::erase_if(requests_, [&frame](const Keyframe& asked) { return asked.name.session == frame.name.session; });
  requests_.push_back(frame);
  AnswerDueKeyframes(output);
  return output;
}

/// Updates the queue of keyframes to check after a map update.
void LoopService::Follow(const MapUpdate& update, Output& output) {
  EndAdjustmentOfCommitted(output);
  FollowAnswer(update.answer, output);
  if (update.newest.number < 0) return;
  const bool begins = update.IsWhole() && !checked_.contains(update.newest.session);
  // After a complete map, all keyframes but the newest of this session count as checked, by a previous loop_process.
  if (update.IsWhole()) {
    const auto& in_map = follower_.newest().in_map();
    checked_.insert(in_map.begin(), in_map.end());
  }
  int64_t checked = begins ? update.newest.number - 1 : Newest(checked_, update.newest.session);
  const auto newest =
      std::find_if(due_.begin(), due_.end(), [&update](const Due& due) { return due.keyframe == update.newest; });
  const bool is_unchecked = newest != due_.end() || checked < update.newest.number;
  if (is_unchecked && AwaitsAdjustment(update)) {
    if (newest != due_.end()) due_.erase(newest);
    unadjusted_.emplace();
    unadjusted_->keyframe = update.newest;
    checked = update.newest.number;
    unadjusted_->t_ns = update.t_ns;
  }
  if (update.committed) {
    checked = std::max(checked, update.newest.number);
    unadjusted_.reset();
  }
  AddDue(update, checked);
  checked_[update.newest.session] = std::max(checked, update.newest.number);
}

void LoopService::FollowAnswer(const LoopAnswer& answer, Output& output) {
  if (!unanswered_ || !IsAnswerTo(answer, *unanswered_)) return;
  if (answer.accepted && unanswered_->more) Adjust(*unanswered_, output);
  unanswered_.reset();
}

/// Queues the unchecked keyframes of the session that are in the map, and the newest, which is answered in any case.
/// (An update with a wrong, large number must not queue many.)
void LoopService::AddDue(const MapUpdate& update, int64_t checked) {
  if (update.newest.number <= checked) return;
  const double now_ms = now_ms_();
  std::vector<Due> newest_first{{update.newest, now_ms}};
  const auto& keyframes = follower_.map().keyframes();
  for (auto entry = keyframes.rbegin(); entry != keyframes.rend(); ++entry) {
    const MapKeyframe& keyframe = entry->second;
    if (keyframe.name.session != update.newest.session) continue;
    if (keyframe.name.number <= checked) break;
    if (keyframe.name.number >= update.newest.number) continue;
    newest_first.push_back({keyframe.name, now_ms});
  }
  due_.insert(due_.end(), newest_first.rbegin(), newest_first.rend());
}

void LoopService::Adjust(const LoopClosure& loop, Output& output) {
  closer_.Follow(follower_.map());
  output.adjustment = closer_.MakeGlobalBundle(follower_.map(), loop);
  output.adjustment->map_version = follower_.version();
  adjusting_ = HeadOf(loop);
}

/// The previous loop_process has adjusted this loop: an adjustment of a later loop must not start from its progress.
void LoopService::EndAdjustmentOfCommitted(Output& output) {
  const bool is_committed = adjusting_ && lockstep_.contains(adjusting_->keyframe.session) &&
                            follower_.newest().HasCommitted(adjusting_->keyframe);
  if (!is_committed) return;
  adjusting_.reset();
  output.ends_adjustment = true;
}

/// Whether a loop ends at the newest keyframe of the update, and it is not committed.
bool LoopService::AwaitsAdjustment(const MapUpdate& update) const {
  const std::vector<LoopEdge>& loops = follower_.map().loops();
  if (update.committed || loops.empty() || !closer_.options().adjustment.enabled) return false;
  const MapKeyframe* keyframe = follower_.map().FindKeyframe(loops.back().keyframe_id);
  return keyframe != nullptr && keyframe->name == update.newest;
}

void LoopService::RequestMissing(Output& output) {
  if (missing_.TakeRequest(now_ms_())) output.missing_keyframes = missing_.Ids(follower_.map());
}

LoopService::Wait LoopService::WaitsFor() {
  if (!missing_.IsOver(now_ms_())) return Wait::kFeatures;
  return unanswered_ ? Wait::kAnswer : Wait::kNothing;
}

/// In lockstep the result must not depend on the length of a network failure.
bool LoopService::HasWaited(const Due& due) const {
  const double now_ms = now_ms_();
  const auto session = lockstep_.find(due.keyframe.session);
  if (session == lockstep_.end()) return now_ms - due.since_ms >= kPatience_ms;
  return now_ms - std::max(due.since_ms, session->second.heard_ms) >= kLockstepPatience_ms;
}

/// In lockstep a committed keyframe has been checked, by a previous loop_process if its updates are resent before its
/// features. The current map is not the one on which to check it.
void LoopService::DropCommitted() {
  std::erase_if(due_, [this](const Due& due) {
    return lockstep_.contains(due.keyframe.session) && follower_.newest().HasCommitted(due.keyframe);
  });
}

/// Keeps the order within a session; a robot whose keyframes are late does not delay the others.
std::deque<LoopService::Due>::iterator LoopService::NextDue() {
  std::set<SessionId> late;
  return std::find_if(due_.begin(), due_.end(), [&](const Due& due) {
    const bool here = closer_.Contains(due.keyframe) || HasWaited(due);
    if (here && !late.contains(due.keyframe.session)) return true;
    late.insert(due.keyframe.session);
    return false;
  });
}

void LoopService::CheckDueKeyframes(Output& output) {
  if (WaitsFor() == Wait::kFeatures) return;
  if (unadjusted_) {
    Adjust(*unadjusted_, output);
    unadjusted_.reset();
  }
  DropCommitted();
  while (WaitsFor() == Wait::kNothing) {
    const auto next = NextDue();
    if (next == due_.end()) return;
    const KeyframeName keyframe = next->keyframe;
    due_.erase(next);
    const double began_ms = now_ms_();
    LoopClosure closure = closer_.Check(follower_.map(), keyframe);
    closure.map_version = follower_.version();
    const double took_ms = now_ms_() - began_ms;
    (closure.kind == LoopClosure::Kind::kLoop ? closure.correct_ms : closure.detect_ms) = took_ms;
    if (closure.kind == LoopClosure::Kind::kLoop) {
      closure.more |= adjusting_.has_value();
      unanswered_ = HeadOf(closure);
    }
    output.closures.push_back(std::move(closure));
  }
}

bool LoopService::IsAnswerable(const Keyframe& frame) {
  // The tracker that sent the request has the map, so its updates are on their way here, too.
  if (!frame.lockstep) return true;
  return follower_.version() && WaitsFor() != Wait::kFeatures &&
         follower_.newest().HasCommitted({frame.name.session, frame.previous_keyframe_id});
}

void LoopService::AnswerDueKeyframes(Output& output) {
  for (auto frame = requests_.begin(); frame != requests_.end();) {
    if (!IsAnswerable(*frame)) {
      ++frame;
      continue;
    }
    closer_.Follow(follower_.map());
    Relocalisation answer = closer_.Relocalise(follower_.map(), frame->features);
    answer.session = frame->name.session;
    answer.frame_id = frame->frame_id;
    answer.t_ns = frame->t_ns;
    answer.map_version = follower_.version();
    output.answers.push_back(answer);
    frame = requests_.erase(frame);
  }
}

}  // namespace plslam::loop
