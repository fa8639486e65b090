// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>

#include "core/ids/ids.h"
#include "core/map/map.h"

namespace plslam::mapping {

/// Number of sessions, the newest ones, that may still continue.
inline constexpr size_t kRunningSessions = 16;

/// Distinguishes the visits of a place: a camera has left it and come back if its path since then is much longer than
/// the distance between the two keyframes. Keyframes of other sessions belong to an earlier visit if they are older
/// than the session. A session whose paths are unknown, of a loaded map or long ago, is one visit.
class Visits {
 public:
  /// A keyframe on the path of its session.
  struct Moment {
    SessionId session;
    KeyframeId keyframe_id = -1;
    double travelled_m = 0.0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.session, self.keyframe_id, self.travelled_m);
    }
  };

  /// Adds a new keyframe.
  void Add(const MapKeyframe& keyframe);
  /// The keyframe is not in the map any more.
  void Remove(KeyframeId keyframe_id);

  /// Whether the session may still continue.
  bool Has(SessionId session) const { return sessions_.contains(session); }

  Moment MomentOf(const MapKeyframe& keyframe) const;
  /// Returns whether `earlier`, at this distance from `keyframe`, belongs to an earlier visit.
  bool IsBefore(const Moment& earlier, double distance_m, const MapKeyframe& keyframe) const;
  /// The same of two keyframes of the map.
  bool IsBefore(const MapKeyframe& earlier, const MapKeyframe& keyframe) const;
  /// Distance up to which keyframes are at the place of this one: three mean steps between keyframes of its session.
  double Near_m(const MapKeyframe& keyframe) const;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.sessions_);
  }

 private:
  struct Session {
    KeyframeId first_id = -1;
    KeyframeId newest_id = -1;
    double travelled_m = 0.0;
    int64_t n_steps = 0;
    std::map<KeyframeId, double> by_keyframe_m;

    double Near_m() const;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.first_id, self.newest_id, self.travelled_m, self.n_steps, self.by_keyframe_m);
    }
  };

  void ForgetSessions();

  /// The newest `kRunningSessions`.
  std::map<SessionId, Session> sessions_;
};

}  // namespace plslam::mapping
