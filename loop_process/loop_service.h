// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/map/map_follower.h"
#include "core/map/map_update.h"
#include "core/places/place_recogniser.h"
#include "loop_process/loop_closer.h"
#include "loop_process/missing_features.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// Returns a recogniser without places; its vocabularies are found by `FindSharedFile`. Throws std::runtime_error with
/// one sentence if one cannot be read.
PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options);

/// loop_process without threads and messages: keeps a copy of the map, and decides when to check and to answer. The
/// same arrivals give the same results, whatever the order between keyframes, map updates and requests.
///
/// Each keyframe is checked once, on the map right after its insertion, when its features have arrived. After a loop
/// has been published, nothing is checked until the map answers it (`MapUpdate::answer`). An accepted loop
/// starts a global bundle adjustment if `LoopCloser::Check` requested one, or if the loop ended a running one. A request
/// of a lockstep session is answered on a map that is committed up to the tracker's last keyframe.
///
/// A complete map (after a restart of mapping_process or loop_process) is used when the features of all its keyframes
/// have arrived, from whichever process; missing ones are waited for during a limited time. Only the newest keyframe
/// of its session is checked. If a loop ends at that keyframe, and the keyframe is not committed, LoopService waits for
/// the global bundle adjustment that the previous loop_process did not finish.
class LoopService {
 public:
  /// Time to wait for missing features.
  static constexpr double kPatience_ms = MissingFeatures::kPatience_ms;
  /// The same for a lockstep session, since the last message of the process that publishes its keyframes; equal to the
  /// other processes' wait in lockstep (`bus.partner_wait_s` by default).
  static constexpr double kLockstepPatience_ms = 15000.0;

  /// Messages to publish, and the adjustment to run meanwhile.
  struct Output {
    std::vector<LoopClosure> closures;
    std::vector<Relocalisation> answers;
    std::optional<GlobalBundleProblem> adjustment;
    /// Keyframes of the map whose features no publisher has resent: request them from mapping_process.
    std::vector<KeyframeId> missing_keyframes;
    /// The running adjustment is obsolete, as is its progress.
    bool ends_adjustment = false;
  };

  /// `now_ms` is the clock, for durations and waits.
  LoopService(LoopCloser closer, std::function<double()> now_ms)
      : closer_(std::move(closer)), now_ms_(std::move(now_ms)) {}

  Output OnKeyframe(const Keyframe& keyframe);
  Output OnUpdate(const MapUpdate& update);
  /// Handles the features of a frame; `frame_id` identifies the request, `previous_keyframe_id` is the tracker's last
  /// keyframe.
  Output OnRequest(const Keyframe& frame);
  /// Called periodically.
  Output OnTick();
  /// An adjustment has been published, without poses if it failed.
  void OnAdjusted(const LoopClosure& adjustment);
  /// A process is alive; `source` as in `Keyframe::source`.
  void OnSignOfLife(SourceId source);

  bool MoveOldToFiles() { return closer_.MoveOldToFiles(); }

  const MapFollower& follower() const { return follower_; }

 private:
  /// Conditions for which the next check waits.
  enum class Wait {
    kNothing,
    kFeatures,  ///< until all features of a complete map have arrived, or none for `kPatience_ms`
    kAnswer,    ///< until the map answers the published loop
  };

  /// A keyframe to be checked, and the time since when.
  struct Due {
    KeyframeName keyframe;
    double since_ms = 0.0;
  };

  /// The process that publishes the keyframes of a lockstep session, and the time of its last message.
  struct LockstepSession {
    SourceId source;
    double heard_ms = 0.0;
  };

  void Follow(const MapUpdate& update, Output& output);
  void FollowAnswer(const LoopAnswer& answer, Output& output);
  void AddDue(const MapUpdate& update, int64_t checked);
  void Adjust(const LoopClosure& loop, Output& output);
  bool AwaitsAdjustment(const MapUpdate& update) const;
  Wait WaitsFor();
  void RequestMissing(Output& output);
  bool HasWaited(const Due& due) const;
  void DropCommitted();
  void EndAdjustmentOfCommitted(Output& output);
  std::deque<Due>::iterator NextDue();
  void CheckDueKeyframes(Output& output);
  void AnswerDueKeyframes(Output& output);
  bool IsAnswerable(const Keyframe& frame);

  LoopCloser closer_;
  std::function<double()> now_ms_;
  MapFollower follower_;
  /// Newest keyframe that was checked, or is queued.
  std::map<SessionId, int64_t> checked_;
  std::deque<Due> due_;
  std::map<SessionId, LockstepSession> lockstep_;  // by session
  MissingFeatures missing_;
  /// The loop whose global bundle adjustment the previous loop_process did not finish.
  std::optional<LoopClosure> unadjusted_;
  /// The loop whose adjustment is running.
  std::optional<LoopClosure> adjusting_;
  /// The published loop that the map has not answered yet, without edges and poses.
  std::optional<LoopClosure> unanswered_;
  std::deque<Keyframe> requests_;
};

}  // namespace plslam::loop
