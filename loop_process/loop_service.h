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

#include "core/map/keyframe.h"
#include "core/map/loop_closure.h"
#include "core/map/map_update.h"
#include "core/places/place_recogniser.h"
#include "loop_process/loop_closer.h"
#include "loop_process/options.h"

namespace plslam::loop {

/// A recogniser without places; `FindSharedFile` finds its vocabularies. Throws std::runtime_error with one sentence
/// where one cannot be read.
PlaceRecogniser LoadPlaces(const VocabularyOptions& files, const PlaceOptions& options);

/// What loop_process does, without threads and messages: keeps a copy of the map, and says when what is to be
/// answered. The same arrivals give the same answers, in whichever order keyframes, updates of the map and requests
/// come in between.
///
/// Each keyframe is checked once, on the map right after it came in, and its features are waited for. While a loop is
/// on its way into the map, nothing else is checked, until the map answers it (`MapUpdate::answer`). The adjustment
/// of the whole map follows a loop that was accepted. A request of a lockstep stream is answered
/// on the map that loop_process has had its say about, as of the tracker's last keyframe.
///
/// A map that comes whole (one of the two processes was started again) is checked when the features of all its
/// keyframes are there, whoever tells them; features that do not come are waited for a while only. Of its keyframes
/// only the newest is checked, of another session none. One that has a loop of its newest keyframe, and is not
/// committed, waits for the adjustment that the loop_process before this one died over.
class LoopService {
 public:
  /// How long features that do not come are waited for.
  static constexpr double kPatience_ms = 3000.0;
  /// The same of features of a lockstep session, since whoever tells its keyframes was last heard of: as the others
  /// wait in lockstep (`wait_s` of the other processes by default).
  static constexpr double kLockstepPatience_ms = 15000.0;

  /// What is to be sent, and what is to be adjusted meanwhile.
  struct Output {
    std::vector<LoopClosure> closures;
    std::vector<Relocalisation> answers;
    std::optional<WholeMapProblem> adjustment;
    /// What is being adjusted is not wanted any more, nor the progress that it has made.
    bool ends_adjustment = false;
  };

  /// `now_ms` measures how long things take, and waits.
  LoopService(LoopCloser closer, std::function<double()> now_ms)
      : closer_(std::move(closer)), now_ms_(std::move(now_ms)) {}

  Output OnKeyframe(const Keyframe& keyframe);
  Output OnUpdate(const MapUpdate& update);
  /// Features of a frame; `frame_id` names the request, `previous_keyframe_id` the tracker's last keyframe.
  Output OnRequest(const Keyframe& frame);
  /// Time passes: now and then.
  Output OnTick();
  /// A process lives; named as in `Keyframe::source`.
  void OnSignOfLife(int64_t source);

  bool LeaveOldInFiles() { return closer_.LeaveOldInFiles(); }

  const MapReplica& replica() const { return replica_; }

 private:
  /// A keyframe to be checked, as its session counts, and since when.
  struct Due {
    int64_t session = 0;
    int64_t keyframe_id = -1;
    double since_ms = 0.0;
  };

  /// Who tells the keyframes of a lockstep session, and when something was last heard of it.
  struct Teller {
    int64_t source = 0;
    double heard_ms = 0.0;
  };

  void Follow(const MapUpdate& update, Output& output);
  void FollowAnswer(const LoopAnswer& answer, Output& output);
  void NoteNewest(const MapUpdate& update);
  void AddDue(const MapUpdate& update, int64_t checked);
  void Adjust(const LoopClosure& loop, Output& output);
  bool AwaitsAdjustment(const MapUpdate& update) const;
  void NoteLacking(bool whole);
  bool IsComplete();
  bool HasWaited(const Due& due) const;
  void DropCommitted();
  void EndAdjustmentOfCommitted(Output& output);
  std::deque<Due>::iterator NextDue();
  void CheckWhatIsDue(Output& output);
  void AnswerWhatIsDue(Output& output);
  bool IsAnswerable(const Keyframe& frame);

  LoopCloser closer_;
  std::function<double()> now_ms_;
  MapReplica replica_;
  int64_t began_version_ = 0;  ///< of that map
  /// Newest keyframe by session: that was checked, that is in the map, that is committed there.
  std::map<int64_t, int64_t> checked_;
  std::map<int64_t, int64_t> newest_;
  std::map<int64_t, int64_t> committed_;
  std::deque<Due> due_;
  std::map<int64_t, Teller> lockstep_;  // by session
  /// Keyframes of a map that came whole, (session, number there), whose features are waited for, and since when none
  /// has come.
  std::set<std::pair<int64_t, int64_t>> lacking_;
  double lacking_since_ms_ = 0.0;
  /// The loop whose adjustment another loop_process died over.
  std::optional<LoopClosure> unadjusted_;
  /// The loop whose adjustment was handed out last.
  std::optional<LoopClosure> adjusting_;
  /// The loop that was told and that the map has not answered yet, without edges and poses.
  std::optional<LoopClosure> told_;
  std::deque<Keyframe> requests_;
};

}  // namespace plslam::loop
