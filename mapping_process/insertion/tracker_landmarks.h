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
  std::vector<LandmarkId> WithdrawnPoints(const Keyframe& keyframe) const;
  std::vector<LandmarkId> WithdrawnLines(const Keyframe& keyframe) const;

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
    LandmarkId Find(TrackId tracker_id) const;
    void Learn(const std::vector<TrackId>& tracker_ids, const std::vector<LandmarkId>& shown, int64_t number);

    template <class Archive, class Self>
    static void Fields(Archive& a, Self& self) {
      a(self.entries_, self.shown_in_);
    }

   private:
    struct Entry {
      LandmarkId map_id = -1;
      int64_t number = -1;

      template <class Archive, class Self>
      static void Fields(Archive& a, Self& self) {
        a(self.map_id, self.number);
      }
    };
    void ForgetBefore(int64_t number);

    std::map<TrackId, Entry> entries_;
    /// Tracker ids by keyframe number, so that forgetting visits old ones only.
    std::map<int64_t, std::vector<TrackId>> shown_in_;
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
  static std::vector<LandmarkId> InMap(const std::vector<Withdrawn>& withdrawn, const Table& table);
  const Session& SessionOf(const Keyframe& keyframe) const;
  void ForgetSessions();

  /// By session, because several robots may be active.
  std::map<SessionId, Session> sessions_;
  int64_t n_learned_ = 0;
};

}  // namespace plslam::mapping
