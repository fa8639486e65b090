// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/ids/ids.h"
#include "core/map/keyframe.h"
#include "core/map/map.h"

namespace plslam::mapping {

/// Returns a keyframe of a map, whose features are expressed in `camera`, as its tracker would publish it.
Keyframe KeyframeOf(const MapKeyframe& entry, const FeaturesView& features, const StereoCamera& camera,
                    const Map& map);

/// Keyframes to be inserted, each once and in the order of its session: after a restart several publishers may send
/// the keyframes of a session (the tracker that continues it, and the history keeper), in any order and repeatedly.
///
/// Within a session the next keyframe is the successor of the last one taken, or 0 for an unknown session. If it is
/// missing, the queue waits for it, and then continues with the next that has arrived. Between sessions the oldest
/// keyframe goes first; but among sessions of one publisher the order of their first keyframes is kept, even if time
/// stamps go back.
///
/// No clock: all times are arguments, in ms of one clock.
class KeyframeQueue {
 public:
  /// Time to wait for a missing keyframe, after a later one has arrived and all earlier ones are taken.
  static constexpr double kPatience_ms = 3000.0;

  /// Largest keyframe number: one each millisecond for 49 days.
  static constexpr int64_t kLast = int64_t{1} << 32;

  struct Arrived {
    Keyframe keyframe;
    double received_ms = 0.0;
    /// Number of missing keyframes of the session before it.
    int64_t missing = 0;
  };

  /// Sets the newest keyframe taken of each session.
  void Restore(const std::map<SessionId, int64_t>& newest_by_session);

  /// Returns false for a keyframe that was added before, or with an impossible number (beyond `kLast`).
  bool Add(const Keyframe& keyframe, double now_ms);

  /// Drops the waiting keyframes of a session.
  void Drop(SessionId session);

  /// Returns the next keyframe; nullptr if there is none, or earlier ones are waited for.
  const Keyframe* Next(double now_ms) const;
  /// As `Next`, and removes it.
  std::optional<Arrived> Take(double now_ms);

  size_t size() const;

 private:
  struct Session {
    int64_t next = 0;
    double taken_ms = 0.0;  ///< time of the last `Take`
    std::map<int64_t, Arrived> waiting;
  };

  static bool IsReady(const Session& session, double now_ms);
  std::vector<SessionId> Held() const;
  std::optional<SessionId> NextSession(double now_ms) const;

  std::map<SessionId, Session> sessions_;
  /// By publisher: sessions in the order of their first keyframes.
  std::map<SourceId, std::vector<SessionId>> published_;
};

}  // namespace plslam::mapping
