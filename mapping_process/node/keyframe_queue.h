// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "core/map/keyframe.h"
#include "core/map/map.h"

namespace plslam::mapping {

/// A keyframe of a map, which is told in `camera`, as its tracker sent it.
Keyframe KeyframeOf(const MapKeyframe& entry, const FeaturesView& features, const StereoCamera& camera,
                    const Map& map);

/// Keyframes that wait to be inserted, each once and in the order of its session, whoever brings them: after a
/// restart a session may be told by several publishers (the tracker that goes on with it, and one who tells of the
/// dead), in any order and more than once.
///
/// Of a session the next is the one behind the newest that was taken, 0 of a session that is not known. Where that is
/// missing it is waited for, and then the session goes on with what there is. Between sessions the oldest keyframe
/// goes first; but of what one publisher has told, a session that it spoke of first goes before the others, also
/// where time goes back.
///
/// No clock: times are given, all of one clock, ms.
class KeyframeQueue {
 public:
  /// How long one that is missing is waited for, from when a later one has come and all before it are taken.
  static constexpr double kPatience_ms = 3000.0;

  /// No session has more keyframes: one each millisecond for 49 days.
  static constexpr int64_t kLast = int64_t{1} << 32;

  struct Arrived {
    Keyframe keyframe;
    double received_ms = 0.0;
    /// Keyframes of the session before it that have never come.
    int64_t missing = 0;
  };

  /// These are taken, by session the newest.
  void Restore(const std::map<int64_t, int64_t>& newest_by_session);

  /// False for one that came before, from whomever, or that cannot be (beyond `kLast`).
  bool Add(const Keyframe& keyframe, double now_ms);

  /// The one whose turn it is; nullptr: there is none, or those before are waited for.
  const Keyframe* Next(double now_ms) const;
  /// Takes it; nullopt as above.
  std::optional<Arrived> Take(double now_ms);

  size_t size() const;

 private:
  struct Session {
    int64_t next = 0;
    double taken_ms = 0.0;  ///< when the last one was
    std::map<int64_t, Arrived> waiting;
  };

  static bool IsReady(const Session& session, double now_ms);
  std::vector<int64_t> Held() const;
  std::optional<int64_t> NextSession(double now_ms) const;

  std::map<int64_t, Session> sessions_;
  /// By publisher: sessions in the order in which it spoke of them.
  std::map<int64_t, std::vector<int64_t>> told_;
};

}  // namespace plslam::mapping
