// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/process/order.h"
#include "core/process/partner_wait.h"
#include "mapping_process/node/keyframe_queue.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// What the owner of the map has to do, in an order that makes results repeatable. No clock and no thread: times are
/// given.
///
/// Of a live stream all keyframes of a session that have come are inserted at once, and what loop_process says is
/// taken over when it comes. Of a lockstep stream each keyframe waits until loop_process has had its say about the
/// one before and that is in the map; where no loop_process is heard of for a while, it goes on without.
///
/// Keyframes come in the order of their sessions, whoever tells of them (`KeyframeQueue`).
///
/// What loop_process said comes again to a process that is started again, and so do the keyframes: about each
/// keyframe it is taken over once that is in the map.
class WorkQueue {
 public:
  using Arrived = KeyframeQueue::Arrived;

  /// Of closures that wait: themselves, and poses, names, edges and pairs in them; some 400 MB. (5,000 keyframes with
  /// 200 loops, told again after a restart, are 4 million.)
  static constexpr size_t kMostParts = 5'000'000;

  struct Work {
    enum class Kind {
      kInsert,        ///< `keyframes`, and adjust the map
      kCorrect,       ///< by `closure`; afterwards commit if `commits`
      kCommit,        ///< loop_process has nothing to say about the newest keyframe
      kAnswer,        ///< the loop of `closure`, which comes again: the map stays as it is
      kPublishWhole,  ///< somebody lacks the map
      kOrder,         ///< of a tool: `order`
      kKeepState,     ///< the map as it is is worth keeping for whoever is started in our place
    };
    Kind kind = Kind::kInsert;
    std::vector<Arrived> keyframes;
    LoopClosure closure;
    bool commits = false;
    bool accepted = false;  ///< kAnswer: the map has a loop of that keyframe, whose adjustment it awaits
    bool lockstep = false;  ///< of the stream that `closure` is about
    bus::Order order;
  };

  /// `state_every`: keyframes after which the state is worth keeping. It is, too, after the map was saved, before a
  /// new session and before another publisher goes on with one. 0: never.
  explicit WorkQueue(const LoopUseOptions& options, int state_every = 0)
      : options_(options), wait_(options.wait_s), state_every_(state_every) {}

  /// The map has these keyframes, by session the newest, and all that was said about them.
  void Restore(const std::map<int64_t, int64_t>& newest_by_session, int64_t newest_session);

  /// One that came before, from whomever, is passed over: false.
  bool Add(const Keyframe& keyframe, double now_ms) { return keyframes_.Add(keyframe, now_ms); }
  /// What was said before the map was restored, about what is in it, is passed over. What is about keyframes that do
  /// not come is kept up to `kMostParts`, the latest.
  void Add(const LoopClosure& closure);
  void AskForWhole() { asked_ = true; }
  /// Orders are carried out one after the other: "localise" when all is said about the newest keyframe, "save" when
  /// the map has all that came before, too (one that was started again first takes in what the histories hold); the
  /// others at once.
  void Add(const bus::Order& order) { orders_.push_back(order); }

  /// Another map has taken the place of this one: nothing that was said about the old one counts any more.
  void BeginAnew(const std::map<int64_t, int64_t>& newest_by_session, int64_t newest_session);

  /// loop_process lives.
  void OnSignOfLife(double now_s) { wait_.OnSignOfLife(now_s); }
  /// Whether a wait for loop_process ended now because it is not heard of.
  bool GiveUp(double now_s) { return wait_.GiveUp(now_s); }

  /// What is to be done next, which then counts as done; nullopt: nothing yet. By the same clock as `Add`.
  std::optional<Work> Take(double now_s);

  /// The map has refused a loop, so no adjustment follows, and all is said about the newest keyframe. Whether that
  /// was not so yet.
  bool Refused();

  /// This many keyframes are in the map now, the last of them this one.
  void Inserted(const Keyframe& keyframe, int count, double now_s);

  size_t n_keyframes() const { return keyframes_.size(); }
  /// Of keyframes and what was said of them.
  size_t n_waiting() const { return keyframes_.size() + closures_.size(); }

 private:
  /// Session, keyframe, map (publisher, version) and kind of a closure.
  using Answer = std::tuple<int64_t, int64_t, int64_t, int64_t, int>;
  struct Newest {
    int64_t session = 0;
    int64_t keyframe_id = -1;
    bool lockstep = false;
    bool committed = true;
    std::set<LoopClosure::Kind> taken;  ///< what was said about it
  };

  static Answer AnswerOf(const LoopClosure& closure);
  void DropOldest();
  bool IsInserted(const LoopClosure& closure) const;
  bool IsAboutNewest(const LoopClosure& closure) const;
  std::optional<Work> TakeClosure(double now_s);
  std::vector<Arrived> TakeKeyframes(double now_s);
  bool IsStateDue(double now_s) const;

  LoopUseOptions options_;
  bus::PartnerWait wait_;
  KeyframeQueue keyframes_;
  std::deque<LoopClosure> closures_;
  size_t n_parts_ = 0;  ///< of these
  std::deque<bus::Order> orders_;
  bool asked_ = false;
  /// No keyframes were waiting at some time since the start.
  bool caught_up_ = false;
  /// Newest keyframe of each session that is in the map.
  std::map<int64_t, int64_t> inserted_;
  Newest newest_;
  /// The same when the map was restored.
  std::map<int64_t, int64_t> restored_;
  /// Who brought the newest of each session, since then.
  std::map<int64_t, int64_t> publishers_;
  std::set<Answer> answers_;
  int state_every_;
  int inserted_since_state_ = 0;
  bool saved_since_state_ = false;
};

}  // namespace plslam::mapping
