// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/map_pages.h"

#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "core/map/map_follower.h"
#include "plslam/map_update_t.hpp"
#include "tests/unit/bus/map_owner.h"

namespace plslam::bus {
namespace {

using Outcome = PageOutcome;
using test::EncodedMap;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

MapUpdate SomeUpdate() {
  plslam::test::RandomMap random(3);
  random.Steps(300);
  random.map().ForgetChanges();
  random.Steps(300);
  MapUpdate update = ChangedPart(random.map(), random.map().TakeChanges());
  update.version = 7;
  update.base_version = 6;
  update.newest.session = 5;
  update.newest.number = 12;
  update.t_ns = 99;
  update.answer = {{4, 11}, MapVersion{{8, 2}, 9, 5}, true};
  update.adjustment = {3, 4, 5, 6, 7, 1.5, 1.25, 0.75, 0.5};
  update.stage_ms = {{"insert", 1.5}, {"adjust", 20.25}};
  return update;
}

std::optional<MapUpdate> Assemble(const std::vector<map_update_t>& pages) {
  MapUpdateAssembler assembler;
  for (size_t i = 0; i < pages.size(); ++i) {
    const Outcome expected = i + 1 == pages.size() ? Outcome::kComplete : Outcome::kTaken;
    if (assembler.Add(pages[i]) != expected) return std::nullopt;
  }
  return assembler.Take();
}

class MapPages : public testing::TestWithParam<int64_t> {};

TEST_P(MapPages, AreSmallEnoughAndGiveTheSameUpdate) {
  const MapUpdate update = SomeUpdate();
  ASSERT_GT(update.removed_points.size() + update.removed_lines.size(), 2U);
  ASSERT_GT(update.points.size(), 20U);
  ASSERT_GT(update.moved_keyframes.size(), 2U);
  const auto pages = CutIntoPages(update, GetParam());
  for (const map_update_t& page : pages) EXPECT_LE(page.getEncodedSize(), GetParam());
  const auto back = Assemble(pages);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->version, 7);
  EXPECT_EQ(back->base_version, 6);
  EXPECT_EQ(back->newest, (KeyframeName{5, 12}));
  EXPECT_EQ(back->t_ns, 99);
  EXPECT_EQ(back->answer, update.answer);
  EXPECT_EQ(back->totals, update.totals);
  EXPECT_EQ(back->adjustment.n_outliers, 7);
  EXPECT_EQ(back->adjustment.reprojection_after_px, 0.5);
  EXPECT_EQ(back->stage_ms, update.stage_ms);
  ASSERT_EQ(back->moved_keyframes.size(), update.moved_keyframes.size());
  EXPECT_EQ(back->moved_keyframes.back().T_w_kf.matrix(), update.moved_keyframes.back().T_w_kf.matrix());
  EXPECT_EQ(back->removed_keyframes, update.removed_keyframes);
  EXPECT_EQ(back->removed_points, update.removed_points);
  EXPECT_EQ(back->removed_lines, update.removed_lines);
  ASSERT_EQ(back->points.size(), update.points.size());
  for (size_t i = 0; i < update.points.size(); ++i) {
    EXPECT_EQ(back->points[i].p_w, update.points[i].p_w);
    EXPECT_EQ(back->points[i].descriptor, update.points[i].descriptor);
    EXPECT_EQ(back->points[i].observations, update.points[i].observations);
    EXPECT_LE((back->points[i].covariance.matrix() - update.points[i].covariance.matrix()).cwiseAbs().maxCoeff(),
              1e-7 * update.points[i].covariance.matrix().cwiseAbs().maxCoeff());
  }
  EXPECT_EQ(EncodedMap(*back), EncodedMap(update)) << "twice through the wire is once through the wire";
}

INSTANTIATE_TEST_SUITE_P(Sizes, MapPages, testing::Values(968, 1200, 5000, 60'000));

TEST(MapPages, ReplicaOfThePagesEqualsTheMap) {
  for (uint64_t seed = 1; seed <= 10; ++seed) {
    test::MapOwner owner(seed);
    MapFollower replica;
    for (int i = 0; i < 20; ++i) {
      const auto update = Assemble(CutIntoPages(owner.Next(40), 3000));
      ASSERT_TRUE(update);
      ASSERT_EQ(replica.Apply(*update), MapStep::kNext);
      ASSERT_EQ(update->totals, replica.map().Totals()) << "seed " << seed << ", version " << update->version;
      ASSERT_EQ(EncodedMap(replica.map()), EncodedMap(owner.map())) << "seed " << seed;
    }
  }
}

TEST(MapPages, ALandmarkSeenByMoreKeyframesThanAPageHolds) {
  MapUpdate update;
  update.version = 1;
  MapLine line;
  for (int i = 0; i < 1000; ++i) line.observations.push_back({3 * i, i % 7});
  for (line.id = 0; line.id < 3; ++line.id) update.lines.push_back(line);
  const auto pages = CutIntoPages(update, 1200);
  EXPECT_GT(pages.size(), 30U);
  for (const map_update_t& page : pages) EXPECT_LE(page.getEncodedSize(), 1200);
  const auto back = Assemble(pages);
  ASSERT_TRUE(back);
  ASSERT_EQ(back->lines.size(), 3U);
  for (const MapLine& received : back->lines) EXPECT_EQ(received.observations, line.observations);
}

TEST(MapPages, AnEmptyUpdateIsOnePage) {
  MapUpdate update;
  update.version = 2;
  update.base_version = 1;
  const auto pages = CutIntoPages(update, 968);
  ASSERT_EQ(pages.size(), 1U);
  EXPECT_TRUE(Assemble(pages));
}

TEST(MapPages, InvalidUpdatesAreNotSent) {
  const std::vector<std::function<void(MapUpdate&)>> faults = {
      [](MapUpdate& u) { u.version = 0; },
      [](MapUpdate& u) { u.base_version = u.version; },
      [](MapUpdate& u) { u.adjustment.rms_after = kNan; },
      [](MapUpdate& u) { u.stage_ms[0].second = kNan; },
      [](MapUpdate& u) { u.points[1].p_w.x() = kNan; },
      [](MapUpdate& u) { u.points[1].covariance = Eigen::Vector3d(1.0, -1.0, 1.0).asDiagonal().toDenseMatrix(); },
      [](MapUpdate& u) { u.points[1].id = u.points[0].id; },
      [](MapUpdate& u) { u.points[1].depth_m = 0.0; },
      [](MapUpdate& u) { u.lines[1].segment_w.q.z() = kNan; },
      [](MapUpdate& u) {
        u.lines[1].observations = {{4, 0}, {3, 0}};
      },
      [](MapUpdate& u) { u.keyframes[1].parent_id = u.keyframes[1].id; },
      [](MapUpdate& u) { u.keyframes[1].covariance(0, 0) = kNan; },
  };
  for (size_t i = 0; i < faults.size(); ++i) {
    MapUpdate update = SomeUpdate();
    EXPECT_NO_THROW(CutIntoPages(update, 60'000));
    faults[i](update);
    EXPECT_THROW(CutIntoPages(update, 60'000), std::invalid_argument) << "fault " << i;
  }
}

TEST(MapPages, VariancesBeyondSinglePrecisionArrive) {
  MapUpdate update = SomeUpdate();
  update.points[0].covariance = 1e60 * Eigen::Matrix3d::Identity();
  EXPECT_TRUE(Assemble(CutIntoPages(update, 60'000)));
}

TEST(MapUpdateAssembler, IgnoresPagesWithoutTheFirstPage) {
  const auto pages = CutIntoPages(SomeUpdate(), 1200);
  ASSERT_GT(pages.size(), 4U);
  MapUpdateAssembler assembler;
  EXPECT_EQ(assembler.Add(pages[1]), Outcome::kPassedOver);
  EXPECT_EQ(assembler.Add(pages[0]), Outcome::kTaken);
  EXPECT_EQ(assembler.Add(pages[2]), Outcome::kPassedOver) << "page 1 is missing";
  EXPECT_EQ(assembler.Add(pages[1]), Outcome::kPassedOver) << "what had come is dropped";
  EXPECT_EQ(assembler.Add(pages[0]), Outcome::kTaken);
  EXPECT_EQ(assembler.Add(pages[0]), Outcome::kTaken) << "begins again";
  map_update_t other = pages[1];
  other.version = 8;
  EXPECT_EQ(assembler.Add(other), Outcome::kPassedOver);
}

TEST(MapUpdateAssembler, PublishersDoNotMix) {
  auto a = CutIntoPages(SomeUpdate(), 1200);
  MapUpdateAssembler assembler;
  for (size_t i = 0; i < a.size(); ++i) {
    for (int64_t source = 1; source <= 3; ++source) {
      a[i].header.source = source;
      ASSERT_EQ(assembler.Add(a[i]), i + 1 == a.size() ? Outcome::kComplete : Outcome::kTaken);
    }
  }
  EXPECT_EQ(assembler.Take().source, 3);
}

TEST(MapUpdateAssembler, RefusesHostilePages) {
  const auto pages = CutIntoPages(SomeUpdate(), 60'000);
  ASSERT_EQ(pages.size(), 1U);
  const std::vector<std::function<void(map_update_t&)>> faults = {
      [](map_update_t& p) { p.n_pages = 0; },
      [](map_update_t& p) { p.n_pages = 2'000'000'000; },
      [](map_update_t& p) { p.page = -1; },
      [](map_update_t& p) { p.page = p.n_pages; },
      [](map_update_t& p) { p.version = -1; },
      [](map_update_t& p) { p.base_version = -1; },
      [](map_update_t& p) { p.base_version = p.version; },
      [](map_update_t& p) { p.session_keyframe_id = -2; },
      [](map_update_t& p) { p.totals.n_points = -1; },
      [](map_update_t& p) { p.answer.accepted = 2; },
      [](map_update_t& p) { p.answer.session_keyframe_id = -2; },
      [](map_update_t& p) { p.adjustment.rms_before = kNan; },
      [](map_update_t& p) { p.adjustment.n_lines = -1; },
      [](map_update_t& p) { p.stages[0].ms = kNan; },
      [](map_update_t& p) { p.stages.resize(1000); },
      [](map_update_t& p) { p.removed_points = {-1}; },
      [](map_update_t& p) {
        p.removed_lines = {4, 4};
      },
      [](map_update_t& p) { p.keyframes[0].T_w_kf.q_wxyz[0] = 5.0; },
      [](map_update_t& p) { p.keyframes[0].covariance[0] = -1.0; },
      [](map_update_t& p) { p.keyframes[0].previous_id = p.keyframes[0].id; },
      [](map_update_t& p) { std::swap(p.keyframes[0], p.keyframes[1]); },
      [](map_update_t& p) { p.moved_keyframes[0].id = -1; },
      [](map_update_t& p) { p.moved_keyframes[0].T_w_kf.position_m[0] = kNan; },
      [](map_update_t& p) { p.moved_keyframes[0].covariance[0] = -1.0; },
      [](map_update_t& p) { std::swap(p.moved_keyframes[0], p.moved_keyframes[1]); },
      [](map_update_t& p) { p.points[0].p_w_m[1] = kNan; },
      [](map_update_t& p) { p.points[0].covariance_m2[3] = -1.0F; },
      [](map_update_t& p) { p.points[0].octave = -1; },
      [](map_update_t& p) { p.points[0].depth_m = -1.0; },
      [](map_update_t& p) { p.points[0].observations.at(0).feature = 2'000'000'000; },
      [](map_update_t& p) { p.points[0].observations.at(0).keyframe_id = -1; },
      [](map_update_t& p) { std::swap(p.points[0], p.points[1]); },
      [](map_update_t& p) { p.points[1] = p.points[0]; },
      [](map_update_t& p) { p.lines[0].q_w_m[2] = kNan; },
      [](map_update_t& p) { p.lines[0].observations.at(0).feature = -1; },
  };
  MapUpdateAssembler assembler;
  for (size_t i = 0; i < faults.size(); ++i) {
    map_update_t hostile = pages[0];
    faults[i](hostile);
    EXPECT_EQ(assembler.Add(hostile), Outcome::kNonsense) << "fault " << i;
  }
  EXPECT_EQ(assembler.Add(pages[0]), Outcome::kComplete);
}

}  // namespace
}  // namespace plslam::bus
