// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/map_file/stored_maps.h"

#include <sodium.h>

#include <cstring>
#include <random>

#include "tests/unit/map/random_map.h"

namespace plslam::test {
namespace {

// As docs/map_files.md has it.
constexpr size_t kLengthAt = 16;
constexpr size_t kSumAt = 24;
constexpr size_t kContentAt = 56;

Descriptor RandomDescriptor(std::mt19937_64& random) { return {random(), random(), random(), random()}; }

double Uniform(std::mt19937_64& random, double max) { return max * static_cast<double>(random() >> 11) * 0x1.0p-53; }

StereoFeatures RandomFeatures(std::mt19937_64& random, int points, int lines) {
  StereoFeatures features;
  for (int i = 0; i < points; ++i) {
    StereoPoint& point = features.points.emplace_back();
    point.left = {.px = {Uniform(random, 752.0), Uniform(random, 480.0)},
                  .response = static_cast<float>(Uniform(random, 1.0)),
                  .angle_rad = static_cast<float>(Uniform(random, 6.0)),
                  .octave = static_cast<int>(random() % 8),
                  .descriptor = RandomDescriptor(random),
                  .scale = 1.0 + Uniform(random, 2.0)};
    point.disparity_px = Uniform(random, 60.0) - 1.0;
    point.sigma_px = Uniform(random, 2.0);
    point.sigma_disparity_px = Uniform(random, 2.0);
  }
  for (int i = 0; i < lines; ++i) {
    StereoLine& line = features.lines.emplace_back();
    line.left = {.segment = {{Uniform(random, 752.0), Uniform(random, 480.0)}, {Uniform(random, 752.0), 3.0}},
                 .response = static_cast<float>(Uniform(random, 1.0)),
                 .octave = static_cast<int>(random() % 4),
                 .descriptor = RandomDescriptor(random)};
    line.disparity_p_px = Uniform(random, 60.0) - 1.0;
    line.sigma_disparity_q_px = Uniform(random, 2.0);
  }
  return features;
}

template <class AnId, class Value>
AnId After(const IdMap<AnId, Value>& values) {
  return AnId(values.empty() ? 0 : values.rbegin()->first.value + 1);
}

void SetRest(StoredMap& stored, std::mt19937_64& random) {
  stored.next_keyframe_id = KeyframeId(After(stored.map.keyframes()).value + static_cast<int64_t>(random() % 3));
  stored.next_point_id = After(stored.map.points());
  stored.next_line_id = LandmarkId(After(stored.map.lines()).value + 5);
  stored.version = static_cast<int64_t>(random() % 1000);
  stored.newest_t_ns = static_cast<int64_t>(random() >> 1);
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    stored.sessions[keyframe.name.session] = {id, keyframe.name.number};
    stored.newest_session = keyframe.name.session;
  }
  for (uint64_t i = random() % 200; i > 0; --i) stored.rig.push_back(static_cast<uint8_t>(random()));
  stored.map.TakeChanges();
}

template <class Landmark>
void PutLandmarks(Map& map, int keyframe, int per_keyframe, int features, std::mt19937_64& random) {
  constexpr int kLength = 6;
  for (int i = 0; i < per_keyframe; ++i) {
    Landmark landmark;
    landmark.id = keyframe * per_keyframe + i;
    landmark.descriptor = RandomDescriptor(random);
    // Each of the keyframes has its share of features for each of the keyframes before it.
    for (int step = 0; step < kLength && keyframe + step < static_cast<int>(map.keyframes().size()); ++step) {
      landmark.observations.push_back({keyframe + step, (step * per_keyframe + i) % features});
    }
    map.Put(landmark);
  }
}

}  // namespace

StoredMap RandomStoredMap(uint64_t seed, int steps) {
  std::mt19937_64 random(seed);
  RandomMap random_map(seed);
  random_map.Steps(steps);
  StoredMap stored;
  stored.map = random_map.map();
  for (const auto& [id, keyframe] : stored.map.keyframes()) stored.features[id] = RandomFeatures(random, 60, 60);
  SetRest(stored, random);
  return stored;
}

StoredMap OfTwoCameras(uint64_t seed, int steps) {
  StoredMap stored = RandomStoredMap(seed, steps);
  for (auto& [id, features] : stored.features) {
    if (id.value % 2 == 1) features.image = TakenImage{-40, 3, 700 + static_cast<int>(id.value), 500, 320.5};
  }
  return stored;
}

StoredMap LongStoredMap(int keyframes, int points, int lines) {
  std::mt19937_64 random(1);
  StoredMap stored;
  for (int i = 0; i < keyframes; ++i) {
    MapKeyframe keyframe;
    keyframe.id = i;
    keyframe.name.number = i;
    keyframe.frame_id = FrameId(i);
    keyframe.parent_id = keyframe.previous_id = i - 1;
    stored.map.Put(keyframe);
    stored.features[i] = RandomFeatures(random, points, lines);
  }
  for (int i = 0; i < keyframes; ++i) {
    PutLandmarks<MapPoint>(stored.map, i, points / 10, points, random);
    PutLandmarks<MapLine>(stored.map, i, lines / 10, lines, random);
  }
  SetRest(stored, random);
  return stored;
}

void Sign(std::vector<uint8_t>& bytes) {
  const uint64_t length = bytes.size() - kContentAt;
  std::memcpy(bytes.data() + kLengthAt, &length, sizeof(length));
  crypto_generichash_state state;
  crypto_generichash_init(&state, nullptr, 0, 32);
  crypto_generichash_update(&state, bytes.data(), kSumAt);
  crypto_generichash_update(&state, bytes.data() + kContentAt, length);
  crypto_generichash_final(&state, bytes.data() + kSumAt, 32);
}

}  // namespace plslam::test
