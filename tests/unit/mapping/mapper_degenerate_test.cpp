// SPDX-License-Identifier: BSD-3-Clause
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "mapping_process/mapper.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam::mapping {
namespace {

using test::FeatureWorld;
using test::MakeKeyframe;
using test::Walk;
using test::WalkOptions;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A walk of ten keyframes, of which a test spoils some. Each step must leave a map without fault that readers take.
class Degenerate : public testing::TestWithParam<bool> {
 protected:
  Degenerate() {
    WalkOptions options;
    options.with_ids = GetParam();
    walk_ = test::MakeWalk(world_, test::TurningPath(10), options);
  }

  void Map(const Keyframe& keyframe) {
    std::string reason;
    ASSERT_TRUE(test::MapOne(keyframe, mapper_, &reason)) << reason;
    ASSERT_EQ(test::WrongWith(mapper_.map()), "") << "after keyframe " << keyframe.name.number;
    ASSERT_EQ(test::ExactlyKnown(mapper_.map()), 0) << "after keyframe " << keyframe.name.number;
    ASSERT_NO_THROW(test::Encoded(mapper_.TakeUpdate())) << "keyframe " << keyframe.name.number;
  }
  void MapFrom(size_t from, size_t to) {
    for (size_t i = from; i < to; ++i) ASSERT_NO_FATAL_FAILURE(Map(walk_.keyframes[i]));
  }
  /// Replaces the features of keyframe i.
  void SetFeatures(size_t i, StereoFeatures features) {
    Keyframe& keyframe = walk_.keyframes[i];
    keyframe.features = std::move(features);
    keyframe.point_landmark_ids.assign(keyframe.features.points.size(), -1);
    keyframe.line_landmark_ids.assign(keyframe.features.lines.size(), -1);
  }
  const MapKeyframe& Newest() const { return mapper_.map().keyframes().rbegin()->second; }
  double NewestError_m() const {
    const SE3& truth = walk_.T_w_c[static_cast<size_t>(Newest().name.number)];
    return (Newest().T_w_kf.translation() - truth.translation()).norm();
  }
  int SharedByNewest() const {
    const auto neighbours = mapper_.map().Neighbours(Newest().id, 1);
    return neighbours.empty() ? 0 : neighbours.front().shared;
  }

  FeatureWorld world_{{120, 40}, 7};
  Walk walk_;
  Mapper mapper_{FeatureWorld::Camera(), MappingOptions()};
};

TEST_P(Degenerate, KeyframeWithoutFeaturesFollowsOdometry) {
  SetFeatures(5, {});
  MapFrom(0, 6);
  const MapKeyframe& previous = *mapper_.map().FindKeyframe(4);
  EXPECT_EQ(Newest().parent_id, 4);
  EXPECT_LT((previous.T_w_kf.Inverse() * Newest().T_w_kf * Newest().T_prevkf_kf.Inverse()).Log().norm(), 1e-9);
  MapFrom(6, 10);
  EXPECT_GT(SharedByNewest(), 40);
  EXPECT_LT(NewestError_m(), 0.02);
}

TEST_P(Degenerate, MapThatBeginsWithoutFeatures) {
  SetFeatures(0, {});
  SetFeatures(1, {});
  MapFrom(0, 2);
  EXPECT_TRUE(mapper_.map().points().empty());
  EXPECT_EQ(mapper_.map().keyframes().size(), 2U);
  MapFrom(2, 10);
  EXPECT_GT(SharedByNewest(), 40);
}

TEST_P(Degenerate, KeyframeWithNothingInCommon) {
  const FeatureWorld strange({120, 40}, 99);
  SetFeatures(5, strange.Observe(walk_.T_w_c[5], 0.4, 5));
  MapFrom(0, 6);
  EXPECT_EQ(SharedByNewest(), 0);
  EXPECT_EQ(Newest().parent_id, 4);
  EXPECT_LT(NewestError_m(), 0.05);
  MapFrom(6, 10);
  EXPECT_GT(SharedByNewest(), 40);
  EXPECT_LT(NewestError_m(), 0.02);
}

TEST_P(Degenerate, TwoIdenticalKeyframesHaveOnePose) {
  walk_.keyframes[5] = walk_.keyframes[4];
  walk_.keyframes[5].name.number = 5;
  walk_.keyframes[5].previous_keyframe_id = 4;
  walk_.keyframes[5].T_prevkf_kf = SE3();
  MapFrom(0, 6);
  const SE3 between = mapper_.map().FindKeyframe(4)->T_w_kf.Inverse() * Newest().T_w_kf;
  EXPECT_LT(between.Log().norm(), 2e-3) << between.Log().transpose();
  EXPECT_GT(SharedByNewest(), 60);
  MapFrom(6, 10);
}

TEST_P(Degenerate, RepeatedKeyframeIsIgnoredWithAReason) {
  MapFrom(0, 5);
  const auto before = test::Encoded(mapper_.map());
  for (const size_t again : {4UL, 2UL, 0UL}) {
    std::string reason;
    EXPECT_FALSE(mapper_.Insert(walk_.keyframes[again], &reason));
    EXPECT_NE(reason.find("keyframe " + std::to_string(again)), std::string::npos) << reason;
  }
  EXPECT_EQ(test::Encoded(mapper_.map()), before);
  MapFrom(5, 10);
}

TEST_P(Degenerate, NoDisparityAtAllFollowsOdometry) {
  for (Keyframe& keyframe : walk_.keyframes) {
    for (StereoPoint& point : keyframe.features.points) point.disparity_px = -1.0;
    for (StereoLine& line : keyframe.features.lines) line.disparity_p_px = line.disparity_q_px = -1.0;
  }
  MapFrom(0, 10);
  EXPECT_TRUE(mapper_.map().points().empty());
  EXPECT_EQ(mapper_.map().keyframes().size(), 10U);
  for (const auto& [id, keyframe] : mapper_.map().keyframes()) {
    const SE3& T_odom_kf = walk_.keyframes[static_cast<size_t>(id.value)].T_odom_kf;
    EXPECT_LT((T_odom_kf.Inverse() * keyframe.T_w_kf).Log().norm(), 1e-9) << id;
  }
}

TEST_P(Degenerate, KeyframeWithoutDisparityUsesOldLandmarks) {
  for (StereoPoint& point : walk_.keyframes[6].features.points) point.disparity_px = -1.0;
  for (StereoLine& line : walk_.keyframes[6].features.lines) line.disparity_p_px = line.disparity_q_px = -1.0;
  MapFrom(0, 7);
  EXPECT_GT(SharedByNewest(), 40);
  EXPECT_LT(NewestError_m(), 0.02);
  MapFrom(7, 10);
}

TEST_P(Degenerate, PointsAtInfinityMakeNoLandmark) {
  for (Keyframe& keyframe : walk_.keyframes) {
    for (StereoPoint& point : keyframe.features.points) point.disparity_px = 0.001;
  }
  MapFrom(0, 10);
  EXPECT_TRUE(mapper_.map().points().empty());
  EXPECT_GT(mapper_.map().lines().size(), 10U);
}

// A front end that is sure of a disparity near zero.
TEST_P(Degenerate, CertainPointsFiftyKilometresAway) {
  std::vector<FeatureWorld::Point> points;
  for (const FeatureWorld::Point& point : world_.points()) {
    const bool far = points.size() % 2 == 0;
    points.push_back({(far ? 10'000.0 : 1.0) * point.p_w, point.descriptor});
  }
  const double inf = std::numeric_limits<double>::infinity();
  walk_ = test::MakeWalk(FeatureWorld(points, world_.lines(), inf), walk_.T_w_c, {.with_ids = GetParam()});
  int far = 0;
  for (Keyframe& keyframe : walk_.keyframes) {
    for (StereoPoint& point : keyframe.features.points) {
      if (point.disparity_px > 2.0) continue;
      point.disparity_px = 0.001;
      point.sigma_disparity_px = 1e-4;
      ++far;
    }
  }
  ASSERT_GT(far, 200);
  MapFrom(0, 10);
  EXPECT_LT(NewestError_m(), 0.03);
}

// The tracker claims to observe landmarks behind the camera.
TEST_P(Degenerate, LandmarksBehindTheCameraAfterATurn) {
  MapFrom(0, 5);
  const std::vector<LandmarkId> seen_before = mapper_.map().LandmarksOf(4).points;
  const SE3 turn(ExpSO3(Eigen::Vector3d(0.0, M_PI, 0.0)), Eigen::Vector3d::Zero());
  Keyframe turned = MakeKeyframe(&walk_.keyframes[4], walk_.keyframes[4].T_odom_kf * turn,
                                 world_.Observe(walk_.T_w_c[4] * turn, 0.4, 55));
  turned.point_map_ids.assign(turned.features.points.size(), -1);
  for (size_t i = 0; i < turned.features.points.size() && i < seen_before.size(); i += 2) {
    turned.point_map_ids[i] = seen_before[i];
  }
  ASSERT_NO_FATAL_FAILURE(Map(turned));
  int behind = 0;
  for (const LandmarkId id : mapper_.map().LandmarksOf(Newest().id).points) {
    if (id >= 0 && (Newest().T_w_kf.Inverse() * mapper_.map().FindPoint(id)->p_w).z() <= 0.0) ++behind;
  }
  EXPECT_EQ(behind, 0);
  const double moved_m = (Newest().T_w_kf.translation() - walk_.T_w_c[4].translation()).norm();
  EXPECT_LT(moved_m, 0.1);
}

TEST_P(Degenerate, SegmentWithoutLengthMakesNoLandmark) {
  for (Keyframe& keyframe : walk_.keyframes) {
    StereoLine& line = keyframe.features.lines[0];
    line.left.segment.q = line.left.segment.p;
    line.disparity_p_px = line.disparity_q_px = 10.0;
  }
  MapFrom(0, 1);
  EXPECT_EQ(mapper_.map().LandmarksOf(0).lines.at(0), -1);
  MapFrom(1, 10);
  EXPECT_LT(NewestError_m(), 0.02);
}

// A line of the map runs through the centre of the camera that claims to observe it as a segment.
TEST_P(Degenerate, SegmentThroughTheCameraCentre) {
  const SE3 T_w_centre = walk_.T_w_c[6];
  const Segment3 segment_w{T_w_centre * Eigen::Vector3d(0.0, 0.0, 1.0), T_w_centre * Eigen::Vector3d(0.0, 0.0, 3.0)};
  for (size_t i = 0; i < walk_.keyframes.size(); ++i) {
    const SE3 T_c_w = walk_.T_w_c[i].Inverse();
    const Eigen::Vector3d p = FeatureWorld::Camera().ProjectStereo(T_c_w * segment_w.p);
    const Eigen::Vector3d q = FeatureWorld::Camera().ProjectStereo(T_c_w * segment_w.q);
    StereoLine seen;
    seen.left.descriptor = test::DescriptorOf(1234);
    seen.left.segment = {p.head<2>(), q.head<2>()};
    if (i == 6) seen.left.segment.q = seen.left.segment.p + Eigen::Vector2d(20.0, 30.0);
    seen.disparity_p_px = p.z();
    seen.disparity_q_px = q.z();
    seen.sigma_px = seen.sigma_disparity_p_px = seen.sigma_disparity_q_px = 0.4;
    walk_.keyframes[i].features.lines.push_back(seen);
    walk_.keyframes[i].line_landmark_ids.push_back(GetParam() ? 1'000'000 : -1);
  }
  MapFrom(0, 6);
  EXPECT_GE(mapper_.map().LandmarksOf(Newest().id).lines.back(), 0) << "seen well from aside";
  MapFrom(6, 10);
  EXPECT_LT(NewestError_m(), 0.02);
}

TEST_P(Degenerate, InvalidCovarianceIsReplacedByALargeOne) {
  walk_.keyframes[3].covariance.setConstant(kNan);
  walk_.keyframes[5].covariance.setZero();
  walk_.keyframes[6].covariance(2, 2) = -1.0;
  walk_.keyframes[7].covariance(1, 1) = std::numeric_limits<double>::infinity();
  MapFrom(0, 10);
  EXPECT_LT(NewestError_m(), 0.02);
  for (const int id : {3, 5, 6, 7}) {
    const MapKeyframe* keyframe = mapper_.map().FindKeyframe(id);
    if (keyframe == nullptr) continue;
    EXPECT_GE(keyframe->relative_covariance.diagonal().minCoeff(), 0.5) << id;
  }
}

std::string NameOfIds(const testing::TestParamInfo<bool>& with_ids) {
  return with_ids.param ? "WithIds" : "WithoutIds";
}

INSTANTIATE_TEST_SUITE_P(Ids, Degenerate, testing::Bool(), NameOfIds);

}  // namespace
}  // namespace plslam::mapping
