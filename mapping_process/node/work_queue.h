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

#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/process/order.h"
#include "core/process/partner_wait.h"
#include "mapping_process/node/keyframe_queue.h"
#include "mapping_process/options.h"

namespace plslam::mapping {

/// Tasks of the owner of the map, in an order that makes results repeatable. No clock and no thread: times are
/// arguments.
///
/// All keyframes of a live session that have arrived are inserted at once, and closures are applied when they arrive.
/// In lockstep each keyframe waits until the closures about the previous one are applied; if no loop_process has been
/// heard of for a while, it does not wait.
///
/// Keyframes come in the order of their sessions, from any publisher (`KeyframeQueue`).
///
/// Keyframes and closures are resent to a restarted process: each closure is applied once its keyframe is in the map.
class WorkQueue {
 public:
  using Arrived = KeyframeQueue::Arrived;

  /// Bound on the size of waiting closures: their number plus that of their poses, names, edges and pairs; some 400 MB.
  /// (5,000 keyframes with 200 loops, resent after a restart, are 4 million.)
  static constexpr size_t kMostParts = 5'000'000;

  /// Number of loops and adjustments that are recognised when they are resent, the newest ones: the map refuses those
  /// computed before later loops. Other closures change nothing when they are resent.
  static constexpr size_t kMostTaken = 1000;

  struct Work {
    enum class Kind {
      kInsert,   ///< insert `keyframes`, and adjust the map
      kCorrect,  ///< apply `closure`; afterwards commit if `commits`
      kCommit,   ///< commit the newest keyframe without loop_process
      kAnswer,   ///< answer the loop of `closure`, which was resent or is not to be applied: the map does not change
      kPublishWhole,  ///< publish the complete map on request
      kOrder,         ///< carry out `order` of a tool
      kKeepState,     ///< write the state for a restart after a crash
      kBeginMap,      ///< replace the map by an empty one, `map_id`, and call `Reset`
    };
    Kind kind = Kind::kInsert;
    std::vector<Arrived> keyframes;
    LoopClosure closure;
    bool commits = false;
    bool accepted = false;  ///< kAnswer: the map has a loop at that keyframe and awaits its global bundle adjustment
    bool lockstep = false;  ///< kCorrect, kAnswer: the newest keyframe is of a lockstep session
    bus::Order order;
    MapId map_id;
  };

  /// `state_every`: number of keyframes after which the state is written. It is also written after the map was saved,
  /// before a new session, and before another publisher continues a session. 0: never.
  /// `awaits_loops`: lockstep keyframes wait for the answer of loop_process, or for `partner_wait_s` without any.
  /// Otherwise loops are refused, and other closures ignored.
  WorkQueue(bool awaits_loops, double partner_wait_s, int state_every = 0)
      : awaits_loops_(awaits_loops), wait_(partner_wait_s), state_every_(state_every) {}

  /// The newest keyframe in the map, and whether its closures are still awaited; a restarted process continues from it.
  struct Newest {
    KeyframeName keyframe;
    bool lockstep = false;
    bool committed = true;
    std::set<LoopClosure::Kind> taken;  ///< closures about it
  };

  /// Sets the newest keyframe of each session in the map. All of them are committed.
  void Restore(const std::map<SessionId, int64_t>& newest_by_session, SessionId newest_session);
  /// The same; closures about `newest` are still accepted if it is not committed.
  void Restore(const std::map<SessionId, int64_t>& newest_by_session, const Newest& newest, double now_s);
  const Newest& newest() const { return newest_; }
  /// Returns whether lockstep keyframes are next; otherwise all that have arrived can be inserted before a stop.
  bool IsLockstep(double now_s) const;

  /// Returns false for a keyframe that was added before, by any publisher.
  bool Add(const Keyframe& keyframe, double now_ms) { return keyframes_.Add(keyframe, now_ms); }
  /// Ignores closures about keyframes that were in the map when it was restored. Closures about keyframes that do not
  /// arrive are kept up to `kMostParts`, the latest ones.
  void Add(const LoopClosure& closure);
  void AskForWhole() { asked_ = true; }
  /// Orders are carried out in sequence: "localise" when the newest keyframe is committed; "save" then, too, when all
  /// earlier keyframes have been inserted (a restarted process first inserts those of the histories); others at once.
  void Add(const bus::Order& order) { orders_.push_back(order); }

  /// Holds a keyframe whose tracker knows of a map that has replaced this one: a previous process carried out the order.
  void AddOfNextMap(const Keyframe& keyframe, double now_ms);
  /// Another map has replaced this one: keyframes and closures of the old one are dropped.
  void Reset(const MapId& map_id, const std::map<SessionId, int64_t>& newest_by_session, SessionId newest_session);
  /// Drops the waiting keyframes of a session.
  void Drop(SessionId session) { keyframes_.Drop(session); }

  /// loop_process is alive.
  void OnSignOfLife(double now_s) { wait_.OnSignOfLife(now_s); }
  /// Returns whether a wait for loop_process ended now because it is not heard of.
  bool GiveUp(double now_s) { return wait_.GiveUp(now_s); }

  /// Returns the next task, which then counts as done; nullopt if there is none yet. Same clock as `Add`.
  std::optional<Work> Take(double now_s);

  /// The map has refused a loop, so no adjustment follows and the newest keyframe is committed. Returns whether it was
  /// not committed before.
  bool Refused();

  /// Returns whether the state is to be written now, which then counts as done.
  bool TakeState(double now_s);

  /// Records that `count` keyframes were inserted, the last of them `keyframe`.
  void Inserted(const Keyframe& keyframe, int count, double now_s);

  size_t n_keyframes() const { return keyframes_.size(); }
  /// Number of waiting keyframes and closures.
  size_t n_waiting() const { return keyframes_.size() + closures_.size(); }
  /// Number of closures, waiting or taken, that are recognised when they are resent.
  size_t n_recognised() const { return answers_.size(); }

 private:
  using Answer = std::tuple<KeyframeName, std::optional<MapVersion>, LoopClosure::Kind>;

  static Answer AnswerOf(const LoopClosure& closure);
  void ForgetTaken(const LoopClosure& closure);
  void DropOldest();
  bool IsInserted(const LoopClosure& closure) const;
  bool IsAboutNewest(const LoopClosure& closure) const;
  std::optional<Work> TakeClosure(double now_s);
  std::vector<Arrived> TakeKeyframes(double now_s);
  bool IsStateDue(double now_s) const;

  bool awaits_loops_;
  bus::PartnerWait wait_;
  KeyframeQueue keyframes_;
  std::vector<Arrived> of_next_map_;
  std::deque<LoopClosure> closures_;
  size_t n_parts_ = 0;  ///< of the closures; see `kMostParts`
  std::deque<bus::Order> orders_;
  bool asked_ = false;
  /// Whether no keyframes were waiting at some time since the start.
  bool caught_up_ = false;
  /// Newest keyframe in the map, by session.
  std::map<SessionId, int64_t> inserted_;
  Newest newest_;
  /// The same at the time of `Restore`.
  std::map<SessionId, int64_t> restored_;
  /// Publisher of the newest keyframe of each session, since then.
  std::map<SessionId, SourceId> publishers_;
  /// Waiting closures, and those in `taken_`.
  std::set<Answer> answers_;
  /// Newest loops and adjustments that were taken, up to `kMostTaken`, in that order.
  std::deque<Answer> taken_;
  int state_every_;
  int inserted_since_state_ = 0;
  bool saved_since_state_ = false;
};

}  // namespace plslam::mapping
