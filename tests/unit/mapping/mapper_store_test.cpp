// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/io/maps/map_file.h"
#include "tests/unit/mapping/loop_world.h"

namespace plslam::mapping {
namespace {

using test::Encoded;
using test::FeatureWorld;
using test::Walk;
using test::WalkOptions;

/// A map of a room, stored between two sessions.
class Stored : public testing::Test {
 protected:
  Stored() {
    for (const Keyframe& keyframe : first_.keyframes) test::MapOne(keyframe, mapper_);
    mapper_.TakeUpdate();
    mapper_.Commit();
  }
  Walk Second() const {
    WalkOptions options;
    options.session = 8;
    options.seed = 2;
    return test::MakeWalk(world_, {path_.begin() + 8, path_.end()}, options);
  }

  FeatureWorld world_{{120, 40}, 7};
  std::vector<SE3> path_ = test::TurningPath(24);
  Walk first_ = test::MakeWalk(world_, {path_.begin(), path_.begin() + 10}, {});
  Mapper mapper_{FeatureWorld::Camera(), MappingOptions()};
  std::string reason_;
};

TEST_F(Stored, RestoredMapperMapsTheNextSessionAlike) {
  const std::vector<uint8_t> file = EncodeMap(mapper_.Store());
  Mapper restored(FeatureWorld::Camera(), MappingOptions(), DecodeMap(file));
  EXPECT_EQ(Encoded(restored.map()), Encoded(mapper_.map()));
  EXPECT_EQ(restored.version(), mapper_.version());
  EXPECT_EQ(restored.Whole().newest.number, mapper_.Whole().newest.number);
  for (const Keyframe& keyframe : Second().keyframes) {
    ASSERT_TRUE(test::MapOne(keyframe, mapper_, &reason_)) << reason_;
    ASSERT_TRUE(test::MapOne(keyframe, restored, &reason_)) << reason_;
    ASSERT_EQ(Encoded(restored.TakeUpdate()), Encoded(mapper_.TakeUpdate())) << "keyframe " << keyframe.name.number;
  }
  EXPECT_EQ(EncodeMap(restored.Store()), EncodeMap(mapper_.Store()));
}

TEST_F(Stored, RestoredMapperClosesTheSameLoop) {
  Mapper restored(FeatureWorld::Camera(), MappingOptions(), DecodeMap(EncodeMap(mapper_.Store())));
  const Walk second = Second();
  for (size_t i = 0; i < 8; ++i) {
    ASSERT_TRUE(test::MapOne(second.keyframes[i], mapper_, &reason_)) << reason_;
    ASSERT_TRUE(test::MapOne(second.keyframes[i], restored, &reason_)) << reason_;
  }
  LoopClosure closure;
  closure.kind = LoopClosure::Kind::kLoop;
  const MapKeyframe& oldest = mapper_.map().keyframes().begin()->second;
  const MapKeyframe& newest = mapper_.map().keyframes().rbegin()->second;
  closure.edges.push_back({oldest.id, newest.id, oldest.T_w_kf.Inverse() * newest.T_w_kf});
  closure.edges.front().covariance.setIdentity();
  ASSERT_TRUE(mapper_.Correct(closure, &reason_)) << reason_;
  ASSERT_TRUE(restored.Correct(closure, &reason_)) << reason_;
  EXPECT_EQ(EncodeMap(restored.Store()), EncodeMap(mapper_.Store()));
}

TEST_F(Stored, KeyframesOfTheStoredMapAreKnown) {
  Mapper restored(FeatureWorld::Camera(), MappingOptions(), DecodeMap(EncodeMap(mapper_.Store())));
  EXPECT_FALSE(restored.Insert(first_.keyframes.back(), &reason_));
  EXPECT_NE(reason_.find("is in the map already"), std::string::npos) << reason_;
}

TEST_F(Stored, EmptyMapIsStoredAndRestored) {
  Mapper empty(FeatureWorld::Camera(), MappingOptions());
  Mapper restored(FeatureWorld::Camera(), MappingOptions(), DecodeMap(EncodeMap(empty.Store())));
  EXPECT_EQ(restored.Whole().newest.number, -1);
  for (const Keyframe& keyframe : first_.keyframes) {
    ASSERT_TRUE(test::MapOne(keyframe, empty, &reason_)) << reason_;
    ASSERT_TRUE(test::MapOne(keyframe, restored, &reason_)) << reason_;
    ASSERT_EQ(Encoded(restored.TakeUpdate()), Encoded(empty.TakeUpdate()));
  }
}

TEST_F(Stored, LocaliseOnlyKeepsTheMapUnchanged) {
  MappingOptions options;
  options.localise_only = true;
  const StoredMap stored = DecodeMap(EncodeMap(mapper_.Store()));
  Mapper restored(FeatureWorld::Camera(), options, stored);
  const std::vector<uint8_t> before = Encoded(restored.Whole());
  for (const Keyframe& keyframe : Second().keyframes) {
    ASSERT_FALSE(restored.Insert(keyframe, &reason_));
    EXPECT_NE(reason_.find("localise_only"), std::string::npos) << reason_;
  }
  EXPECT_FALSE(restored.Correct(test::AdjustByTruth(restored.map(), path_), &reason_));
  EXPECT_NE(reason_.find("localise_only"), std::string::npos) << reason_;
  EXPECT_EQ(Encoded(restored.Whole()), before);
  EXPECT_EQ(restored.Whole().totals, mapper_.Whole().totals);
}

}  // namespace
}  // namespace plslam::mapping
