// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/files/archive.h"
#include "core/ids/ids.h"
#include "core/io/maps/map_file_check.h"
#include "core/io/maps/map_file_fields.h"

// Encoding of parts of maps in map files and mapper states: each after its number of elements, ascending by id, and
// checked when it is read. Throw std::runtime_error, in a sentence without its subject.
namespace plslam::map_file {

template <class AnId, class Value>
void WriteValues(archive::Writer& write, const IdMap<AnId, Value>& values) {
  write(static_cast<uint64_t>(values.size()));
  for (const auto& [id, value] : values) write(value);
}

/// Writes the values with these ids, which must exist.
template <class AnId, class Value>
void WriteValues(archive::Writer& write, const IdMap<AnId, Value>& values, const std::vector<AnId>& ids) {
  write(static_cast<uint64_t>(ids.size()));
  for (const AnId id : ids) write(values.at(id));
}

/// Values by number, ascending.
template <class Key, class Value>
void ReadByNumber(archive::Reader& read, std::map<Key, Value>& values) {
  for (uint64_t n = read.ReadCount(sizeof(int64_t) + archive::MinBytes<Value>()); n > 0; --n) {
    Key id{};
    read(id);
    if (!values.empty() && id <= values.rbegin()->first)
      throw std::runtime_error("numbers are not in ascending order");
    read(values.try_emplace(values.end(), id)->second);
  }
}

/// Calls take(value) for each.
template <class Value, class Take>
void ReadValues(archive::Reader& read, const Take& take) {
  decltype(Value::id) last_id = -1;
  for (uint64_t n = read.ReadCount(archive::MinBytes<Value>()); n > 0; --n) {
    Value value;
    read(value);
    if (value.id <= last_id) throw std::runtime_error("keyframes or landmarks are not in ascending order");
    last_id = value.id;
    take(value);
  }
}

inline void ReadKeyframes(archive::Reader& read, StoredMap& stored) {
  ReadValues<MapKeyframe>(read, [&](const MapKeyframe& keyframe) {
    Check(keyframe);
    stored.map.Put(keyframe);
  });
}

/// Returns how many observations they have, which must be of features that are there.
template <class Landmark>
int64_t ReadLandmarks(archive::Reader& read, StoredMap& stored) {
  int64_t n_observations = 0;
  ReadValues<Landmark>(read, [&](const Landmark& landmark) {
    Check(landmark, stored.features);
    n_observations += static_cast<int64_t>(landmark.observations.size());
    stored.map.Put(landmark);
  });
  return n_observations;
}

inline void ReadFeatures(archive::Reader& read, KeyframeFeatures& features) {
  std::map<KeyframeId, StereoFeatures> values;
  ReadByNumber(read, values);
  for (auto& [id, of_keyframe] : values) {
    Check(id, of_keyframe);
    features.insert_or_assign(id, KeptFeatures(std::move(of_keyframe)));
  }
}

inline void ReadImages(archive::Reader& read, KeyframeFeatures& features) {
  std::map<KeyframeId, TakenImage> images;
  ReadByNumber(read, images);
  for (const auto& [id, image] : images) {
    Check(id, image, features);
    features.at(id).image = image;
  }
}

/// The verticals measured from the keyframes that have one.
inline std::map<KeyframeId, UpDirection> UpDirectionsOf(const Map& map) {
  std::map<KeyframeId, UpDirection> ups;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (keyframe.up) ups[id] = *keyframe.up;
  }
  return ups;
}

/// The same of keyframes with these ids, which must exist.
inline std::map<KeyframeId, UpDirection> UpDirectionsOf(const Map& map, const std::vector<KeyframeId>& ids) {
  std::map<KeyframeId, UpDirection> ups;
  for (const KeyframeId id : ids) {
    if (const MapKeyframe& keyframe = map.keyframes().at(id); keyframe.up) ups[id] = *keyframe.up;
  }
  return ups;
}

/// After the keyframes.
inline void ReadUpDirections(archive::Reader& read, Map& map) {
  std::map<KeyframeId, UpDirection> ups;
  ReadByNumber(read, ups);
  for (const auto& [id, up] : ups) {
    Check(id, up, map);
    MapKeyframe keyframe = *map.FindKeyframe(id);
    keyframe.up = up;
    map.Put(keyframe);
  }
}

inline void ReadLoops(archive::Reader& read, Map& map) {
  std::vector<LoopEdge> loops;
  read(loops);
  for (const LoopEdge& loop : loops) {
    Check(loop);
    map.Add(loop);
  }
}

}  // namespace plslam::map_file
