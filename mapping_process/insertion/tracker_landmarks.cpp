// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/tracker_landmarks.h"

#include <algorithm>
#include <set>

#include "core/map/landmark_types.h"

namespace plslam::mapping {
namespace {

// Keyframes after which an unobserved landmark of the tracker is forgotten; the tracker drops it much sooner.
constexpr int64_t kRememberedKeyframes = 60;
// Sessions that are remembered, the most recently active ones.
constexpr size_t kRememberedSessions = 16;

template <class Type, class Table>
std::vector<LandmarkId> AssociationsOf(size_t n, const std::vector<LandmarkId>& given,
                                       const std::vector<TrackId>& tracker_ids, const Table& table, const Map& map) {
  std::vector<LandmarkId> from_tracker(n, -1);
  std::set<LandmarkId> taken;
  const auto associate = [&](size_t i, LandmarkId id) {
    if (from_tracker[i] < 0 && Type::Find(map, id) != nullptr && taken.insert(id).second) from_tracker[i] = id;
  };
  for (size_t i = 0; i < tracker_ids.size(); ++i) {
    associate(i, table.Find(tracker_ids[i]));
  }
  for (size_t i = 0; i < given.size(); ++i) associate(i, given[i]);
  return from_tracker;
}

}  // namespace

const TrackerLandmarks::Session& TrackerLandmarks::SessionOf(const Keyframe& keyframe) const {
  static const Session kNone;
  const auto known = sessions_.find(keyframe.name.session);
  return known == sessions_.end() ? kNone : known->second;
}

std::vector<LandmarkId> TrackerLandmarks::InMap(const std::vector<Withdrawn>& withdrawn, const Table& table) {
  std::vector<LandmarkId> map_ids;
  for (const Withdrawn& landmark : withdrawn) {
    for (const LandmarkId id : {landmark.map_id, table.Find(landmark.landmark_id)}) {
      if (id >= 0) map_ids.push_back(id);
    }
  }
  return map_ids;
}

std::vector<LandmarkId> TrackerLandmarks::WithdrawnPoints(const Keyframe& keyframe) const {
  return InMap(keyframe.withdrawn_points, SessionOf(keyframe).points);
}

std::vector<LandmarkId> TrackerLandmarks::WithdrawnLines(const Keyframe& keyframe) const {
  return InMap(keyframe.withdrawn_lines, SessionOf(keyframe).lines);
}

Association TrackerLandmarks::Associations(const Keyframe& keyframe, const Map& map) const {
  const Session& session = SessionOf(keyframe);
  return {AssociationsOf<PointType>(keyframe.features.points.size(), keyframe.point_map_ids,
                                    keyframe.point_landmark_ids, session.points, map),
          AssociationsOf<LineType>(keyframe.features.lines.size(), keyframe.line_map_ids, keyframe.line_landmark_ids,
                                   session.lines, map)};
}

Association TrackerLandmarks::Given(const Keyframe& keyframe, const Map& map) {
  return {AssociationsOf<PointType>(keyframe.features.points.size(), keyframe.point_map_ids, {}, Table(), map),
          AssociationsOf<LineType>(keyframe.features.lines.size(), keyframe.line_map_ids, {}, Table(), map)};
}

void TrackerLandmarks::Learn(const Keyframe& keyframe, const Map::FeatureLandmarks& shown) {
  Session& session = sessions_[keyframe.name.session];
  session.learned = ++n_learned_;
  session.points.Learn(keyframe.point_landmark_ids, shown.points, keyframe.name.number);
  session.lines.Learn(keyframe.line_landmark_ids, shown.lines, keyframe.name.number);
  ForgetSessions();
}

void TrackerLandmarks::ForgetSessions() {
  if (sessions_.size() <= kRememberedSessions) return;
  sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(),
                                   [](const auto& a, const auto& b) { return a.second.learned < b.second.learned; }));
}

LandmarkId TrackerLandmarks::Table::Find(TrackId tracker_id) const {
  const auto known = entries_.find(tracker_id);
  return known == entries_.end() ? -1 : known->second.map_id;
}

void TrackerLandmarks::Table::Learn(const std::vector<TrackId>& tracker_ids, const std::vector<LandmarkId>& shown,
                                    int64_t number) {
  std::vector<TrackId>& shown_now = shown_in_[number];
  for (size_t i = 0; i < std::min(tracker_ids.size(), shown.size()); ++i) {
    if (tracker_ids[i] < 0 || shown[i] < 0) continue;
    entries_[tracker_ids[i]] = {shown[i], number};
    shown_now.push_back(tracker_ids[i]);
  }
  ForgetBefore(number - kRememberedKeyframes);
}

void TrackerLandmarks::Table::ForgetBefore(int64_t number) {
  while (!shown_in_.empty() && shown_in_.begin()->first < number) {
    for (const TrackId id : shown_in_.begin()->second) {
      const auto entry = entries_.find(id);
      if (entry != entries_.end() && entry->second.number < number) entries_.erase(entry);
    }
    shown_in_.erase(shown_in_.begin());
  }
}

}  // namespace plslam::mapping
