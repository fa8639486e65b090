// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/loop/ring_world.h"

#include <gtest/gtest.h>

#include "tools/train_vocabulary/vocabulary_trainer.h"

namespace plslam::test {
namespace {

constexpr double kWorldRadius_m = 4.0;
constexpr double kStep_m = 0.4;

template <class Landmark>
Vocabulary Train(const std::vector<Landmark>& landmarks, FeatureType type) {
  // Images of a dozen landmarks each: every word is rare.
  std::vector<std::vector<Descriptor>> images;
  for (size_t i = 0; i < landmarks.size(); ++i) {
    if (i % 12 == 0) images.emplace_back();
    images.back().push_back(landmarks[i].descriptor);
  }
  train_vocabulary::TrainingOptions options;
  options.depth = 3;
  options.min_descriptors = 4;
  return train_vocabulary::TrainVocabulary(images, type, options);
}

WalkOptions WithoutIds(uint64_t seed) {
  WalkOptions options;
  options.with_ids = false;
  options.seed = seed;
  return options;
}

}  // namespace

PlaceRecogniser PlacesOf(const FeatureWorld& world) {
  return {Train(world.points(), FeatureType::kPoints), Train(world.lines(), FeatureType::kLines), PlaceOptions()};
}

Ring::Ring(int keyframes, uint64_t seed)
    : world(MakeRing(kWorldRadius_m, 1500, 150, seed)),
      walk(MakeWalk(world, RingPath(kWorldRadius_m, kStep_m, keyframes), WithoutIds(seed))) {}

Closing::Closing(const PlaceRecogniser& places, const loop::LoopOptions& options)
    : mapper(FeatureWorld::Camera(), mapping::MappingOptions()), closer(FeatureWorld::Camera(), places, options) {}

LoopClosure Closing::Show(const Keyframe& keyframe) {
  EXPECT_TRUE(MapOne(keyframe, mapper));
  closer.AddKeyframe(keyframe);
  return closer.Check(mapper.map(), keyframe.name);
}

void Closing::TakeOver(const LoopClosure& loop) {
  if (loop.kind != LoopClosure::Kind::kLoop) return;
  std::string reason;
  EXPECT_TRUE(mapper.Correct(loop, &reason)) << reason;
  loops.push_back(loop);
}

Closing CloseLoops(const Ring& ring, const loop::LoopOptions& options) {
  Closing closing(PlacesOf(ring.world), options);
  for (const Keyframe& keyframe : ring.walk.keyframes) closing.TakeOver(closing.Show(keyframe));
  return closing;
}

}  // namespace plslam::test
