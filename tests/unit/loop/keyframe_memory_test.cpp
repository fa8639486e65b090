// SPDX-License-Identifier: BSD-3-Clause
#include "loop_process/keyframe_memory.h"

#include <gtest/gtest.h>

#include "tests/unit/mapping/mapping_world.h"
#include "tools/train_vocabulary/vocabulary_trainer.h"

namespace plslam::test {
namespace {

PlaceRecogniser SmallPlaces() {
  std::vector<std::vector<Descriptor>> images;
  for (uint64_t i = 0; i < 60; ++i) images.push_back({DescriptorOf(i), DescriptorOf(1000 + i)});
  train_vocabulary::TrainingOptions options;
  options.depth = 2;
  options.min_descriptors = 2;
  return {train_vocabulary::TrainVocabulary(images, FeatureType::kPoints, options),
          train_vocabulary::TrainVocabulary(images, FeatureType::kLines, options), PlaceOptions()};
}

Keyframe Named(SessionId session, int64_t number) {
  Keyframe keyframe;
  keyframe.name.session = session;
  keyframe.name.number = number;
  StereoPoint point;
  point.left.descriptor = DescriptorOf(static_cast<uint64_t>(10 * session.value + number));
  keyframe.features.points.assign(static_cast<size_t>(number + 1), point);
  return keyframe;
}

MapKeyframe InMap(KeyframeId id, SessionId session, int64_t number) {
  MapKeyframe keyframe;
  keyframe.id = id;
  keyframe.name.session = session;
  keyframe.name.number = number;
  return keyframe;
}

size_t PointsOf(const loop::KeyframeMemory& memory, KeyframeId id) { return memory.features().at(id).points.size(); }

TEST(KeyframeMemory, FeaturesBeforeTheMapAndAfterIt) {
  loop::KeyframeMemory memory(SmallPlaces());
  Map map;
  memory.Add(Named(1, 0));
  memory.Follow(map);
  EXPECT_TRUE(memory.features().empty());
  map.Put(InMap(0, 1, 0));
  map.Put(InMap(1, 1, 1));
  memory.Follow(map);
  EXPECT_EQ(memory.features().size(), 1U);
  memory.Add(Named(1, 1));
  memory.Follow(map);
  ASSERT_EQ(memory.features().size(), 2U);
  EXPECT_EQ(PointsOf(memory, 0), 1U);
  EXPECT_EQ(PointsOf(memory, 1), 2U);
  EXPECT_TRUE(memory.places().Has(1));
  EXPECT_EQ(memory.point_nodes().at(1).node.size(), 2U);
}

TEST(KeyframeMemory, RemovedKeyframesAreDropped) {
  loop::KeyframeMemory memory(SmallPlaces());
  Map map;
  for (int i = 0; i < 4; ++i) {
    map.Put(InMap(i, 1, i));
    memory.Add(Named(1, i));
  }
  memory.Follow(map);
  map.RemoveKeyframe(1);
  memory.Follow(map);
  EXPECT_EQ(memory.features().size(), 3U);
  EXPECT_FALSE(memory.places().Has(1));
  // Removed permanently: a later keyframe of the session is in the map.
  map.Put(InMap(1, 1, 1));
  memory.Follow(map);
  EXPECT_FALSE(memory.features().contains(1));
}

// Another map's, say.
TEST(KeyframeMemory, UnmappedSessionKeepsOnlyItsNewest) {
  constexpr int64_t kMost = loop::KeyframeMemory::kMostUntaken;
  loop::KeyframeMemory memory(SmallPlaces());
  Map map;
  const auto add = [&memory](SessionId session, int64_t number) {
    Keyframe keyframe = Named(session, 0);
    keyframe.name.number = number;
    memory.Add(keyframe);
  };
  for (int64_t i = 0; i < kMost + 2; ++i) add(2, i);
  memory.Follow(map);
  EXPECT_TRUE(memory.Contains({2, 0})) << "there is no map yet";
  map.Put(InMap(0, 1, 0));
  memory.Add(Named(1, 0));
  memory.Follow(map);
  EXPECT_FALSE(memory.Contains({2, 1}));
  EXPECT_TRUE(memory.Contains({2, 2}));
  add(2, kMost + 2);
  EXPECT_FALSE(memory.Contains({2, 2})) << "nor do they grow while the map stays as it is";
  EXPECT_TRUE(memory.Contains({2, kMost + 2}));
  map.Put(InMap(1, 2, kMost + 2));
  memory.Follow(map);
  EXPECT_EQ(PointsOf(memory, 1), 1U);
}

TEST(KeyframeMemory, MappedSessionIsKeptForARestartedMap) {
  constexpr int64_t kMany = loop::KeyframeMemory::kMostUntaken + 10;
  loop::KeyframeMemory memory(SmallPlaces());
  Map map;
  for (int i = 0; i < kMany; ++i) {
    Keyframe keyframe = Named(1, 0);
    keyframe.name.number = i;
    memory.Add(keyframe);
    map.Put(InMap(i, 1, i));
  }
  memory.Follow(map);
  Map rebuilt;
  rebuilt.Put(InMap(0, 2, 0));
  memory.Follow(rebuilt);
  EXPECT_TRUE(memory.Contains({1, 0}));
  rebuilt.Put(InMap(1, 1, 0));
  memory.Follow(rebuilt);
  EXPECT_EQ(PointsOf(memory, 1), 1U);
}

// A bounded map forgets sessions of earlier days, each from its first keyframe to its last.
TEST(KeyframeMemory, EndedSessionsAreDropped) {
  loop::KeyframeMemory memory(SmallPlaces());
  Map map;
  for (int i = 0; i < 3; ++i) {
    map.Put(InMap(i, 1, i));
    memory.Add(Named(1, i));
  }
  map.Put(InMap(3, 2, 0));
  memory.Add(Named(2, 0));
  memory.Add(Named(2, 1));
  memory.Follow(map, true);
  for (const int id : {0, 2}) {
    map.RemoveKeyframe(id);
    memory.Follow(map, true);
  }
  EXPECT_TRUE(memory.Contains({1, 2})) << "an older state of the map may have it";
  map.RemoveKeyframe(1);
  memory.Follow(map, true);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(memory.Contains({1, i})) << i;
  EXPECT_TRUE(memory.Contains({2, 0}));
  EXPECT_TRUE(memory.Contains({2, 1}));
  memory.Add(Named(1, 2));
  map.Put(InMap(2, 1, 2));
  memory.Follow(map);
  EXPECT_EQ(PointsOf(memory, 2), 3U) << "it is back in the map, and published again";
}

TEST(KeyframeMemory, RestartedMapUsesKeyframesUnderOtherIds) {
  loop::KeyframeMemory memory(SmallPlaces());
  Map map;
  for (int i = 0; i < 5; ++i) {
    map.Put(InMap(i, 1, i));
    memory.Add(Named(1, i));
  }
  memory.Follow(map);
  Map rebuilt;
  rebuilt.Put(InMap(0, 1, 0));
  memory.Follow(rebuilt);
  EXPECT_EQ(memory.features().size(), 1U);
  rebuilt.Put(InMap(1, 1, 2));
  memory.Follow(rebuilt);
  ASSERT_EQ(memory.features().size(), 2U);
  EXPECT_EQ(PointsOf(memory, 1), 3U) << "id 1 is another keyframe now";
  rebuilt.Put(InMap(2, 1, 4));
  memory.Follow(rebuilt);
  EXPECT_EQ(PointsOf(memory, 2), 5U);
}

}  // namespace
}  // namespace plslam::test
