// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "core/map/map.h"

namespace plslam::test {

/// A map with all events that can occur: keyframes are inserted, landmarks of both feature types are created, observed
/// again, moved, fused, deprived of observations and removed, and keyframes are removed. Everything depends on the seed
/// only.
class RandomMap {
 public:
  explicit RandomMap(uint64_t seed) : random_(seed) {}

  /// One thing happens.
  void Step();
  void Steps(int n);

  Map& map() { return map_; }
  const Map& map() const { return map_; }

 private:
  void AddKeyframe();
  void CloseLoop();
  void Move();
  template <class Landmark>
  void Change(const IdMap<LandmarkId, Landmark>& landmarks, LandmarkId& next_id);
  template <class Landmark>
  void Fuse(const IdMap<LandmarkId, Landmark>& landmarks);
  void Remove(const MapPoint& point) { map_.RemovePoint(point.id); }
  void Remove(const MapLine& line) { map_.RemoveLine(line.id); }
  void Place(MapPoint& point);
  void Place(MapLine& line);

  uint64_t Draw(uint64_t n) { return random_() % n; }
  SE3 DrawPose();
  Eigen::Matrix3d DrawCovariance();
  std::vector<Observation> DrawObservations();
  template <class AnId, class Value>
  const Value& DrawFrom(const IdMap<AnId, Value>& values);

  std::mt19937_64 random_;
  Map map_;
  KeyframeId next_keyframe_ = 0;
  LandmarkId next_point_ = 0;
  LandmarkId next_line_ = 0;
};

}  // namespace plslam::test
