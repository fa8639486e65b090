// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/ids/ids.h"
#include "vo_process/options.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"
#include "vo_process/tracking/landmarks/tracker_local_map.h"

namespace plslam::vo {

/// Values by id, those of one id in their given order: built once, then only queried. It uses one block of memory,
/// where std::multimap uses one for each value.
template <class AnId, class Value>
class IdIndex {
 public:
  using Entry = std::pair<AnId, Value>;

  explicit IdIndex(std::vector<Entry> entries) : entries_(std::move(entries)) {
    std::stable_sort(entries_.begin(), entries_.end(),
                     [](const Entry& a, const Entry& b) { return a.first < b.first; });
  }

  /// Returns an empty span if there is none.
  std::span<const Entry> Find(AnId id) const {
    const auto [first, last] = std::equal_range(entries_.begin(), entries_.end(), Entry(id, Value()),
                                                [](const Entry& a, const Entry& b) { return a.first < b.first; });
    return {first, last};
  }

 private:
  std::vector<Entry> entries_;
};

/// Returns the indices in `list` by id; skips negative ids.
template <class AnId, class Element>
IdIndex<AnId, size_t> IndicesBy(AnId Element::*id, const std::vector<Element>& list) {
  std::vector<std::pair<AnId, size_t>> places;
  places.reserve(list.size());
  for (size_t i = 0; i < list.size(); ++i) {
    if (list[i].*id >= 0) places.emplace_back(list[i].*id, i);
  }
  return IdIndex(std::move(places));
}

/// A scalar measurement of a 3D position: `residual` = measured - expected, `J` its derivative by the position.
struct LinearMeasurement {
  Eigen::RowVector3d J = Eigen::RowVector3d::Zero();
  double residual = 0.0;
  double variance = 1.0;
};

/// Updates a position by independent linearised measurements (Kalman filter). Returns false and changes nothing if the
/// result is not finite.
bool FuseMeasurements(std::span<const LinearMeasurement> measurements, Eigen::Vector3d& position,
                      Eigen::Matrix3d& covariance);

// Functions common to lists of point and of line landmarks.

/// `unseen_frames` of landmarks from the map: they are matched only in searches around a known pose.
inline constexpr int kAdoptedUnseenFrames = 3;

/// Descriptors of the landmarks seen within `max_unseen_frames`, and their indices in the list.
struct KnownDescriptors {
  std::vector<Descriptor> descriptors;
  std::vector<int> owners;
};

template <class Landmark>
KnownDescriptors RecentDescriptors(const std::vector<Landmark>& landmarks, int max_unseen_frames) {
  KnownDescriptors known;
  for (int i = 0; i < static_cast<int>(landmarks.size()); ++i) {
    if (landmarks[i].unseen_frames > max_unseen_frames) continue;
    known.descriptors.push_back(landmarks[i].descriptor);
    known.owners.push_back(i);
  }
  return known;
}

/// Updates landmarks with the map's values by `set(known, is_new, landmark)`, adds those that are missing (as unseen,
/// so that they are searched once the pose is known), and of those that are the same in the map keeps only one. If two
/// landmarks of the map have the same tracker id, the first one gets it.
template <class Known, class Landmark, class Set>
void AdoptEach(const std::vector<Adopted<Known>>& adopted, TrackId& next_id, std::vector<Landmark>& landmarks,
               const Set& set) {
  const IdIndex<TrackId, size_t> by_id = IndicesBy(&Landmark::id, landmarks);
  const IdIndex<LandmarkId, size_t> by_map_id = IndicesBy(&Landmark::map_id, landmarks);
  std::vector<char> taken(landmarks.size(), 0);
  std::vector<char> drop(landmarks.size(), 0);
  std::vector<size_t> same;
  for (const Adopted<Known>& entry : adopted) {
    same.clear();
    const auto add = [&](auto found) {
      if (found.empty() || taken[found.back().second]) return;
      same.push_back(found.back().second);
      taken[same.back()] = 1;
    };
    for (const TrackId id : entry.tracker_ids) add(by_id.Find(id));
    add(by_map_id.Find(entry.landmark->id));
    const bool is_new = same.empty();
    const size_t first = is_new ? 0 : *std::min_element(same.begin(), same.end());
    for (const size_t i : same) drop[i] = i == first ? 0 : 1;
    if (is_new) {
      Landmark& landmark = landmarks.emplace_back();
      landmark.id = next_id++;
      landmark.unseen_frames = kAdoptedUnseenFrames;
    }
    Landmark& landmark = is_new ? landmarks.back() : landmarks[first];
    landmark.map_id = entry.landmark->id;
    landmark.map_observations = static_cast<int>(entry.landmark->observations.size());
    set(*entry.landmark, is_new, landmark);
  }
  drop.resize(landmarks.size(), 0);
  size_t i = 0;
  std::erase_if(landmarks, [&](const Landmark&) { return drop[i++] != 0; });
}

/// Returns the new index of each landmark after moving those flagged in `taken` to another list: its index there, or
/// its index among the remaining ones.
inline std::vector<int> PlacesAfterTaking(const std::vector<char>& taken) {
  std::vector<int> places;
  places.reserve(taken.size());
  int next[2] = {0, 0};
  for (const char flag : taken) places.push_back(next[flag != 0 ? 1 : 0]++);
  return places;
}

/// Moves the landmarks flagged in `taken` out of the list, in their order.
template <class Landmark>
std::vector<Landmark> TakeFlagged(const std::vector<char>& taken, std::vector<Landmark>& landmarks) {
  std::vector<Landmark> result;
  size_t kept = 0;
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (taken[i] != 0) {
      result.push_back(landmarks[i]);
    } else {
      landmarks[kept++] = landmarks[i];
    }
  }
  landmarks.resize(kept);
  return result;
}

/// Returns copies of the landmarks flagged in `chosen`, in their order.
template <class Landmark>
std::vector<Landmark> CopyFlagged(const std::vector<char>& chosen, const std::vector<Landmark>& landmarks) {
  std::vector<Landmark> result;
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (chosen[i] != 0) result.push_back(landmarks[i]);
  }
  return result;
}

/// Removes landmarks that have been out of view, or in view but not matched, for too long.
template <class Landmark>
void DropStale(const LandmarkOptions& options, std::vector<Landmark>& landmarks) {
  std::erase_if(landmarks, [&options](const Landmark& landmark) {
    return landmark.unseen_frames > options.max_unseen_frames || landmark.missed > options.max_missed;
  });
}

}  // namespace plslam::vo
