// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/tracker_landmarks.h"

#include <gtest/gtest.h>

#include "tests/unit/localisation/handmade_map.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::DescriptorOf;
using test::FeatureWorld;
using test::HandmadeMap;

using Ids = std::vector<LandmarkId>;
using TrackIds = std::vector<TrackId>;

/// Keyframes in a row: 0 and 1 see points 0..29, 1 and 2 points 30..59, 3 points 60..69.
class AssociationTest : public testing::Test {
 protected:
  AssociationTest() {
    for (uint64_t i = 0; i < 100; ++i) descriptors_.push_back(DescriptorOf(i));
    for (int i = 0; i < 4; ++i) {
      m_.AddKeyframe({Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.05 * i, 0.0, 0.0)});
    }
    m_.Tie({0, 1}, 30, 0, descriptors_);
    m_.Tie({1, 2}, 30, 30, descriptors_);
    m_.Tie({3}, 10, 60, descriptors_);
  }
  static Keyframe WithPoints(SessionId session, int64_t number, const TrackIds& tracker_ids, const Ids& map_ids) {
    Keyframe keyframe;
    keyframe.name.session = session;
    keyframe.name.number = number;
    keyframe.features.points.resize(tracker_ids.size());
    keyframe.point_landmark_ids = tracker_ids;
    keyframe.point_map_ids = map_ids;
    return keyframe;
  }
  static Ids Range(int from, int to) {
    Ids ids;
    for (int id = from; id < to; ++id) ids.push_back(id);
    return ids;
  }

  std::vector<Descriptor> descriptors_;
  HandmadeMap m_;
};

TEST_F(AssociationTest, LinesCountTwice) {
  EXPECT_EQ((Association{{1, -1, 2, 3}, {-1, 4}}).Weight(), 5);
  EXPECT_EQ(Association().Weight(), 0);
}

TEST_F(AssociationTest, LearntAssociationsPrecedeTheGivenOnes) {
  TrackerLandmarks tracker;
  tracker.Learn(WithPoints(1, 0, {500, 501, 502, -1}, {}), {{10, 11, -1, 13}, {}});
  const Keyframe next = WithPoints(1, 1, {501, 500, 502, 503, -1}, {-1, 20, 21, -1, 22});
  EXPECT_EQ(tracker.Associations(next, m_.map).points, (Ids{11, 10, 21, -1, 22}))
      << "what was learnt goes before what is given";
}

TEST_F(AssociationTest, NoDuplicateAndNoRemovedLandmarks) {
  TrackerLandmarks tracker;
  tracker.Learn(WithPoints(1, 0, {500, 501}, {}), {{10, 11}, {}});
  m_.map.RemovePoint(11);
  const Keyframe next = WithPoints(1, 1, {-1, 500, 501, -1}, {10, -1, -1, 4711});
  EXPECT_EQ(tracker.Associations(next, m_.map).points, (Ids{-1, 10, -1, -1}));
}

TEST_F(AssociationTest, AssociationsOfOtherSessionsAreNotUsed) {
  TrackerLandmarks tracker;
  tracker.Learn(WithPoints(1, 0, {500}, {}), {{10}, {}});
  EXPECT_EQ(tracker.Associations(WithPoints(2, 0, {500}, {}), m_.map).points, (Ids{-1}));
  EXPECT_EQ(tracker.Associations(WithPoints(2, 0, {500}, {12}), m_.map).points, (Ids{12}));
}

TEST_F(AssociationTest, RobotsLearnInTurn) {
  TrackerLandmarks tracker;
  tracker.Learn(WithPoints(1, 0, {500}, {}), {{10}, {}});
  tracker.Learn(WithPoints(2, 0, {500}, {}), {{20}, {}});
  EXPECT_EQ(tracker.Associations(WithPoints(1, 1, {500}, {}), m_.map).points, (Ids{10}));
  EXPECT_EQ(tracker.Associations(WithPoints(2, 1, {500}, {}), m_.map).points, (Ids{20}));
  for (SessionId session = 3; session < 40; ++session) tracker.Learn(WithPoints(session, 0, {500}, {}), {{30}, {}});
  EXPECT_EQ(tracker.Associations(WithPoints(1, 1, {500}, {}), m_.map).points, (Ids{-1})) << "sessions of long ago";
}

TEST_F(AssociationTest, LandmarksNotObservedAnyMoreAreForgotten) {
  TrackerLandmarks tracker;
  tracker.Learn(WithPoints(1, 0, {500, 501}, {}), {{10, 11}, {}});
  for (int k = 1; k < 200; ++k) tracker.Learn(WithPoints(1, k, {501}, {}), {{11}, {}});
  EXPECT_EQ(tracker.Associations(WithPoints(1, 200, {500, 501}, {}), m_.map).points, (Ids{-1, 11}));
}

TEST_F(AssociationTest, ShortListsOfIdsAreHarmless) {
  TrackerLandmarks tracker;
  Keyframe keyframe = WithPoints(1, 0, {-1, -1, -1}, {});
  keyframe.point_landmark_ids.clear();
  EXPECT_EQ(tracker.Associations(keyframe, m_.map).points, (Ids{-1, -1, -1}));
  tracker.Learn(keyframe, {{3}, {}});
}

TEST_F(AssociationTest, LocalMapExcludesAssociatedLandmarks) {
  Ids expected = Range(0, 60);
  std::erase(expected, 3);
  std::erase(expected, 35);
  EXPECT_EQ(LocalMapOf({{3, -1, 35}, {}}, -1, m_.map, 15).points, expected);
}

TEST_F(AssociationTest, LocalMapIncludesNeighboursUpToALimit) {
  Ids expected = Range(0, 60);
  std::erase(expected, 3);
  EXPECT_EQ(LocalMapOf({{3}, {}}, -1, m_.map, 15).points, expected) << "keyframe 2 by way of 1";
  Ids near = Range(0, 30);
  std::erase(near, 3);
  EXPECT_EQ(LocalMapOf({{3}, {}}, -1, m_.map, 1).points, near) << "the older of two equal ones";
}

TEST_F(AssociationTest, LocalMapAroundThePreviousKeyframe) {
  EXPECT_EQ(LocalMapOf({{-1, -1}, {}}, 3, m_.map, 15).points, Range(0, 70)) << "with those before it";
  EXPECT_EQ(LocalMapOf({}, 3, m_.map, 1).points, Range(60, 70));
  EXPECT_TRUE(LocalMapOf({}, -1, m_.map, 15).points.empty());
}

TEST_F(AssociationTest, SearchAddsToExistingAssociations) {
  const KeyframeId id = m_.AddKeyframe({Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.2, 0.0, 0.0)});
  for (const int seen : {0, 7, 8})
    m_.SeePoint(id, m_.map.FindPoint(seen)->p_w, descriptors_[static_cast<size_t>(seen)]);
  Association association{{-1, 42, -1}, {}};
  SearchByProjection(m_.map, {{0, 7, 8}, {}}, m_.map.FindKeyframe(id)->T_w_kf, m_.features[id],
                     FeatureWorld::Camera(), LocalisationOptions(), association);
  EXPECT_EQ(association.points, (Ids{0, 42, 8}));
}

}  // namespace
}  // namespace plslam::mapping
