// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/ids/ids.h"
#include "core/localisation/local_map.h"
#include "core/map/keyframe.h"

namespace plslam::mapping {

/// Maps the tracker's landmarks (by session and tracker id) to landmarks of the map.
class TrackerLandmarks {
 public:
  /// Returns the associations of the features by the tracker: with landmarks of the map that it received, and with its
  /// own landmarks that earlier keyframes brought.
  Association Associations(const Keyframe& keyframe, const Map& map) const;

  /// Returns only the associations with landmarks of the map that the tracker received.
  static Association Given(const Keyframe& keyframe, const Map& map);

  /// Returns the landmarks of the map that the keyframe withdraws.
  std::vector<int64_t> WithdrawnPoints(const Keyframe& keyframe) const;
  std::vector<int64_t> WithdrawnLines(const Keyframe& keyframe) const;

  /// Stores the final landmarks of a keyframe's features, and forgets those not observed for long.
  void Learn(const Keyframe& keyframe, const Map::FeatureLandmarks& shown);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.sessions_, self.n_learned_);
  }

 private:
  /// Landmarks of one feature type.
  class Table {
   public:
    /// Returns -1 if unknown.
    int64_t Find(int64_t tracker_id) const;
    void Learn(const std::vector<int64_t>& tracker_ids, const std::vector<int64_t>& shown, int64_t keyframe_id);

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.entries_, self.shown_in_);
    }

   private:
    struct Entry {
      int64_t map_id = -1;
      int64_t keyframe_id = -1;

      template <class Archive, class Self>
      static void Fields(Archive& a, Self& self) {
        a(self.map_id, self.keyframe_id);
      }
    };
    void ForgetBefore(int64_t keyframe_id);

    std::map<int64_t, Entry> entries_;
    /// Tracker ids by keyframe, so that forgetting visits old ones only.
    std::map<int64_t, std::vector<int64_t>> shown_in_;
  };
  struct Session {
    Table points;
    Table lines;
    int64_t learned = 0;

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.points, self.lines, self.learned);
    }
  };
  static std::vector<int64_t> InMap(const std::vector<Withdrawn>& withdrawn, const Table& table);
  const Session& SessionOf(const Keyframe& keyframe) const;
  void ForgetSessions();

  /// By session, because several robots may be active.
  std::map<SessionId, Session> sessions_;
  int64_t n_learned_ = 0;
};

}  // namespace plslam::mapping
