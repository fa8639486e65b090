// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/localisation/local_map.h"
#include "core/map/keyframe.h"

namespace plslam::mapping {

/// Landmarks of the tracker (by session and its ids) and the landmarks of the map they became.
class TrackerLandmarks {
 public:
  /// What the tracker says of the features: landmarks it was given, and those of its own that earlier keyframes
  /// brought.
  Association Associations(const Keyframe& keyframe, const Map& map) const;

  /// Landmarks that the tracker was given by the map, whatever its own say.
  static Association Given(const Keyframe& keyframe, const Map& map);

  /// Landmarks of the map that the keyframe takes back.
  std::vector<int64_t> WithdrawnPoints(const Keyframe& keyframe) const;
  std::vector<int64_t> WithdrawnLines(const Keyframe& keyframe) const;

  /// Remembers which landmarks the features of a keyframe turned out to show, and forgets what was not seen for long.
  void Learn(const Keyframe& keyframe, const Map::FeatureLandmarks& shown);

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.sessions_, self.n_learned_);
  }

 private:
  /// Landmarks of one feature type.
  class Table {
   public:
    /// -1 where it is not known.
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
    /// By keyframe, so that forgetting looks at what is old only.
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

  /// Several robots may be at work at once.
  std::map<int64_t, Session> sessions_;
  int64_t n_learned_ = 0;
};

}  // namespace plslam::mapping
