// SPDX-License-Identifier: BSD-3-Clause
#include <deque>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/vo/small_scene.h"

namespace plslam::vo {
namespace {

using test::LandmarksOf;
using test::MakeScene;
using test::Scene;

const SE3 kT_w_odom(ExpSO3(Eigen::Vector3d(0.3, -0.5, 0.2)), Eigen::Vector3d(3.0, -1.0, 2.0));
const Eigen::Vector3d kOffset(0.05, -0.02, 0.03);
const Eigen::Matrix3d kCovariance_w = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
constexpr int kFirstMapId = 500;

/// A map that has landmarks of the scene `kOffset` from where the tracker has them.
struct AdoptedPatch {
  std::deque<MapPoint> map_points;
  std::deque<MapLine> map_lines;
  TrackerLocalMap patch{kT_w_odom, 0.0, {}, {}};

  void Add(const Eigen::Vector3d& p_odom, std::vector<TrackId> tracker_ids) {
    MapPoint& point = map_points.emplace_back();
    point.id = LandmarkId(kFirstMapId + map_points.size() - 1);
    point.p_w = kT_w_odom * (p_odom + kOffset);
    point.covariance = kCovariance_w;
    point.descriptor = {1, 2, 3, 4};
    point.octave = 2;
    point.depth_m = 3.5;
    point.observations = {{0, 1}, {1, 1}, {4, 1}};
    patch.points.push_back({&point, std::move(tracker_ids)});
  }
  void Add(const Segment3& segment_odom, std::vector<TrackId> tracker_ids) {
    MapLine& line = map_lines.emplace_back();
    line.id = LandmarkId(kFirstMapId + map_lines.size() - 1);
    line.segment_w = {kT_w_odom * (segment_odom.p + kOffset), kT_w_odom * (segment_odom.q + kOffset)};
    line.covariance_p = kCovariance_w;
    line.covariance_q = 4.0 * kCovariance_w;
    line.descriptor = {1, 2, 3, 4};
    line.observations = {{0, 1}, {1, 1}, {4, 1}};
    patch.lines.push_back({&line, std::move(tracker_ids)});
  }
};

// Common interface of both feature types, so that one test serves both.
struct Points {
  using Landmark = PointLandmark;
  static const std::vector<Landmark>& Of(const LocalLandmarks& landmarks) { return landmarks.points.landmarks(); }
  static const auto& In(const Scene& scene) { return scene.points; }
  static TrackId NextId(const LocalLandmarks& landmarks) { return landmarks.next_point_id; }
  static Eigen::Vector3d Place(const Landmark& landmark) { return landmark.p_odom; }
  static Eigen::Matrix3d Covariance(const Landmark& landmark) { return landmark.covariance; }
};
struct Lines {
  using Landmark = LineLandmark;
  static const std::vector<Landmark>& Of(const LocalLandmarks& landmarks) { return landmarks.lines.landmarks(); }
  static const auto& In(const Scene& scene) { return scene.lines; }
  static TrackId NextId(const LocalLandmarks& landmarks) { return landmarks.next_line_id; }
  static Eigen::Vector3d Place(const Landmark& landmark) { return landmark.segment_odom.p; }
  static Eigen::Matrix3d Covariance(const Landmark& landmark) { return landmark.covariance_p; }
};

template <class Type>
class LandmarkAdoption : public testing::Test {
 protected:
  const Scene scene_ = MakeScene();
  LocalLandmarks landmarks_ = LandmarksOf(scene_);
  AdoptedPatch map_;

  const std::vector<typename Type::Landmark>& Now() const { return Type::Of(landmarks_); }
  const typename Type::Landmark* Find(TrackId id) const {
    for (const auto& landmark : Now()) {
      if (landmark.id == id) return &landmark;
    }
    return nullptr;
  }
  const typename Type::Landmark* FindByMapId(LandmarkId map_id) const {
    const typename Type::Landmark* found = nullptr;
    for (const auto& landmark : Now()) {
      if (landmark.map_id != map_id) continue;
      EXPECT_EQ(found, nullptr) << "two landmarks of map id " << map_id;
      found = &landmark;
    }
    return found;
  }
};

using Kinds = testing::Types<Points, Lines>;
TYPED_TEST_SUITE(LandmarkAdoption, Kinds);

TYPED_TEST(LandmarkAdoption, OwnLandmarksTakeThePositionOfTheMap) {
  const auto before = this->Now();
  this->map_.Add(TypeParam::In(this->scene_)[4], {4});
  this->landmarks_.Adopt(this->map_.patch);
  ASSERT_EQ(this->Now().size(), before.size());
  for (size_t i = 0; i < before.size(); ++i) {
    const auto& now = this->Now()[i];
    const Eigen::Vector3d moved = TypeParam::Place(now) - TypeParam::Place(before[i]);
    EXPECT_LT((moved - (i == 4 ? kOffset : Eigen::Vector3d(0.0, 0.0, 0.0))).norm(), 1e-9) << i;
    EXPECT_EQ(now.map_id, i == 4 ? kFirstMapId : -1);
    EXPECT_EQ(now.map_observations, i == 4 ? 3 : 0);
    EXPECT_EQ(now.id, before[i].id);
    EXPECT_EQ(now.seen, before[i].seen);
    EXPECT_EQ(now.unseen_frames, before[i].unseen_frames);
    EXPECT_EQ(now.descriptor, before[i].descriptor) << "as last seen, which the map cannot know better";
  }
  const Eigen::Matrix3d R = kT_w_odom.R();
  const Eigen::Matrix3d expected = R.transpose() * kCovariance_w * R;
  EXPECT_LT((TypeParam::Covariance(this->Now()[4]) - expected).norm(), 1e-6 * expected.norm());
}

TYPED_TEST(LandmarkAdoption, UnknownLandmarksAreAddedAsNotSeenLately) {
  const size_t before = this->Now().size();
  const TrackId next_id = TypeParam::NextId(this->landmarks_);
  this->map_.Add(TypeParam::In(this->scene_)[5], {});
  this->map_.Add(TypeParam::In(this->scene_)[6], {777});  // dropped by the tracker since
  this->landmarks_.Adopt(this->map_.patch);
  ASSERT_EQ(this->Now().size(), before + 2);
  EXPECT_EQ(TypeParam::NextId(this->landmarks_).value, next_id.value + 2);
  const auto& added = this->Now()[before];
  EXPECT_EQ(added.id, next_id);
  EXPECT_EQ(added.map_id, kFirstMapId);
  EXPECT_GT(added.unseen_frames, 1);
  EXPECT_EQ(added.descriptor, (Descriptor{1, 2, 3, 4}));
  const auto& own = *this->Find(5);
  EXPECT_LT((TypeParam::Place(added) - TypeParam::Place(own) - kOffset).norm(), 1e-9);
  // A second time they are here already.
  this->landmarks_.Adopt(this->map_.patch);
  EXPECT_EQ(this->Now().size(), before + 2);
  EXPECT_EQ(TypeParam::NextId(this->landmarks_).value, next_id.value + 2);
}

// Octaves are of the pixels of the camera that found them.
TEST(PointAdoption, OctaveDepthScalesWithTheFocalLength) {
  const Scene scene = MakeScene();
  for (const double ratio : {1.0, 0.5, 2.5}) {
    LocalLandmarks landmarks = LandmarksOf(scene);
    AdoptedPatch map;
    map.Add(scene.points[4], {});
    map.patch.f_px = kCamera.f_px / ratio;
    landmarks.Adopt(map.patch);
    const PointLandmark& added = landmarks.points.landmarks().back();
    EXPECT_EQ(added.octave, 2);
    EXPECT_DOUBLE_EQ(added.depth_m, ratio * 3.5);
  }
}

TYPED_TEST(LandmarkAdoption, OldestOfIdenticalLandmarksIsKept) {
  const size_t before = this->Now().size();
  this->map_.Add(TypeParam::In(this->scene_)[4], {9, 4, 7});
  this->landmarks_.Adopt(this->map_.patch);
  ASSERT_EQ(this->Now().size(), before - 2);
  EXPECT_EQ(this->Find(9), nullptr);
  EXPECT_EQ(this->Find(7), nullptr);
  ASSERT_NE(this->Find(4), nullptr);
  EXPECT_EQ(this->Find(4)->map_id, kFirstMapId);
  // Others are untouched and in their order.
  for (size_t i = 1; i < this->Now().size(); ++i) EXPECT_LT(this->Now()[i - 1].id, this->Now()[i].id);
}

TYPED_TEST(LandmarkAdoption, NewLandmarkIsFusedWithThatOfTheMap) {
  const size_t before = this->Now().size();
  this->map_.Add(TypeParam::In(this->scene_)[5], {});
  this->landmarks_.Adopt(this->map_.patch);
  ASSERT_EQ(this->Now().size(), before + 1);
  // A keyframe has shown since that the tracker's number 5 is the same.
  this->map_.patch.points.clear();
  this->map_.patch.lines.clear();
  AdoptedPatch later;
  later.Add(TypeParam::In(this->scene_)[5], {5});
  this->landmarks_.Adopt(later.patch);
  EXPECT_EQ(this->Now().size(), before);
  ASSERT_NE(this->Find(5), nullptr);
  EXPECT_EQ(this->FindByMapId(kFirstMapId), this->Find(5));
}

// Keyframes may have observed one of the tracker's landmarks as two of the map (a wrong match, corrected since): each
// then has its own.
TYPED_TEST(LandmarkAdoption, LandmarkOfTwoMapLandmarksGoesToTheFirst) {
  const TrackId next_id = TypeParam::NextId(this->landmarks_);
  const auto& places = TypeParam::In(this->scene_);
  this->map_.Add(places[1], {1, 2});
  this->map_.Add(places[0], {0, 1});
  this->map_.Add(places[2], {2});
  this->landmarks_.Adopt(this->map_.patch);
  const auto* first = this->FindByMapId(kFirstMapId);
  const auto* second = this->FindByMapId(kFirstMapId + 1);
  const auto* third = this->FindByMapId(kFirstMapId + 2);
  ASSERT_TRUE(first != nullptr && second != nullptr && third != nullptr);
  EXPECT_EQ(first->id, 1);
  EXPECT_EQ(second->id, 0);
  EXPECT_GE(third->id, next_id) << "its own landmark went to the second";
  EXPECT_EQ(this->Find(2), nullptr);
}

TYPED_TEST(LandmarkAdoption, EmptyLocalMapChangesNothing) {
  const auto before = this->Now();
  this->landmarks_.Adopt(this->map_.patch);
  ASSERT_EQ(this->Now().size(), before.size());
  EXPECT_EQ(TypeParam::Place(this->Now()[3]), TypeParam::Place(before[3]));
}

}  // namespace
}  // namespace plslam::vo
