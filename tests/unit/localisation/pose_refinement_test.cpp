// SPDX-License-Identifier: BSD-3-Clause
#include "core/localisation/pose_refinement.h"

#include <gtest/gtest.h>

#include "tests/support/dense_algebra.h"
#include "tests/unit/mapping/mapping_world.h"

namespace plslam {
namespace {

using test::FeatureWorld;

/// The world as a map (landmark i of it is landmark i of the map, known to a centimetre), and a keyframe in it.
class PoseRefinement : public testing::TestWithParam<FeatureWorld::Counts> {
 protected:
  PoseRefinement() {
    for (size_t i = 0; i < world_.points().size(); ++i) {
      MapPoint point;
      point.id = LandmarkId(i);
      point.p_w = world_.points()[i].p_w;
      point.covariance = 1e-4 * Eigen::Matrix3d::Identity();
      point.descriptor = world_.points()[i].descriptor;
      map_.Put(point);
      local_.points.push_back(point.id);
    }
    for (size_t i = 0; i < world_.lines().size(); ++i) {
      MapLine line;
      line.id = LandmarkId(i);
      line.segment_w = world_.lines()[i].segment_w;
      line.covariance_p = line.covariance_q = 1e-4 * Eigen::Matrix3d::Identity();
      line.descriptor = world_.lines()[i].descriptor;
      map_.Put(line);
      local_.lines.push_back(line.id);
    }
    for (const StereoPoint& seen : features_.points)
      truth_.points.push_back(IdOf(seen.left.descriptor, map_.points()));
    for (const StereoLine& seen : features_.lines) truth_.lines.push_back(IdOf(seen.left.descriptor, map_.lines()));
  }
  template <class Landmark>
  static LandmarkId IdOf(const Descriptor& descriptor, const IdMap<LandmarkId, Landmark>& landmarks) {
    for (const auto& [id, landmark] : landmarks) {
      if (landmark.descriptor == descriptor) return id;
    }
    return -1;
  }
  std::optional<KeyframePose> Refine(const SE3& T_w_kf, Association& association) const {
    return RefinePose(map_, features_, FeatureWorld::Camera(), T_w_kf, MotionOptions(), association);
  }
  std::optional<KeyframePose> Recognise(Association& association) const {
    return RecognisePose(map_, local_, features_, FeatureWorld::Camera(), LocalisationOptions(), 40, association);
  }
  double Error(const KeyframePose& pose) const { return (T_w_c_.Inverse() * pose.T_w_kf).Log().norm(); }

  FeatureWorld world_{GetParam(), 4};
  SE3 T_w_c_{ExpSO3(Eigen::Vector3d(0.1, 0.7, -0.1)), Eigen::Vector3d(0.3, 0.1, -0.2)};
  StereoFeatures features_ = world_.Observe(T_w_c_, 0.4, 8);
  const SE3 away_ = SE3::Exp((Vector6d() << 0.05, -0.03, 0.04, 0.02, -0.03, 0.02).finished());
  Map map_;
  LocalMap local_;
  Association truth_;
};

TEST_P(PoseRefinement, FindsThePoseWithinItsCovariance) {
  Association association = truth_;
  const auto pose = Refine(T_w_c_ * away_, association);
  ASSERT_TRUE(pose);
  EXPECT_LT(Error(*pose), 0.01);
  const Vector6d error = (T_w_c_.Inverse() * pose->T_w_kf).Log();
  EXPECT_LT(test::ChiSquare(error, pose->covariance), 22.5) << "chi-square of 6, 99.9 %";
  EXPECT_GT(association.Weight(), 9 * truth_.Weight() / 10);
}

TEST_P(PoseRefinement, FeaturesThatDisagreeLoseTheirLandmark) {
  Association association = truth_;
  std::vector<size_t> wrong_points;
  for (size_t i = 0; i + 1 < association.points.size(); i += 10) {
    std::swap(association.points[i], association.points[i + 1]);
    wrong_points.push_back(i);
  }
  std::vector<size_t> wrong_lines;
  for (size_t i = 0; i + 1 < association.lines.size(); i += 10) {
    std::swap(association.lines[i], association.lines[i + 1]);
    wrong_lines.push_back(i);
  }
  const auto pose = Refine(T_w_c_ * away_, association);
  ASSERT_TRUE(pose);
  EXPECT_LT(Error(*pose), 0.01);
  for (const size_t i : wrong_points) EXPECT_EQ(association.points[i], -1) << "point " << i;
  for (const size_t i : wrong_lines) EXPECT_EQ(association.lines[i], -1) << "line " << i;
}

TEST_P(PoseRefinement, UndeterminedPoseIsNotRefined) {
  Association few = truth_;
  for (size_t i = 2; i < few.points.size(); ++i) few.points[i] = -1;
  for (size_t i = 1; i < few.lines.size(); ++i) few.lines[i] = -1;
  const Association before = few;
  EXPECT_FALSE(Refine(T_w_c_, few));
  EXPECT_EQ(few.points, before.points);
  EXPECT_EQ(few.lines, before.lines);
}

TEST_P(PoseRefinement, RecognisedWithoutAPriorPose) {
  Association association;
  const auto pose = Recognise(association);
  ASSERT_TRUE(pose);
  EXPECT_LT(Error(*pose), 0.01);
  for (size_t i = 0; i < association.points.size(); ++i) {
    if (association.points[i] < 0) continue;
    EXPECT_EQ(association.points[i], truth_.points[i]) << "point " << i;
  }
  EXPECT_GT(association.Weight(), truth_.Weight() / 2);
}

TEST_P(PoseRefinement, AnotherPlaceIsNotRecognised) {
  features_ = FeatureWorld(GetParam(), 77).Observe(T_w_c_, 0.4, 8);
  Association association = truth_;
  EXPECT_FALSE(Recognise(association));
  EXPECT_EQ(association.points, truth_.points) << "left as it was";
}

// The same descriptors at other positions: descriptors agree, geometry does not.
TEST_P(PoseRefinement, AppearanceAloneIsNotEnough) {
  const StereoFeatures seen = features_;
  for (size_t i = 0; i < seen.points.size(); ++i) {
    features_.points[i].left.descriptor = seen.points[(i + 7) % seen.points.size()].left.descriptor;
  }
  for (size_t i = 0; i < seen.lines.size(); ++i) {
    features_.lines[i].left.descriptor = seen.lines[(i + 7) % seen.lines.size()].left.descriptor;
  }
  Association association;
  EXPECT_FALSE(Recognise(association)) << association.Weight() << " of " << truth_.Weight();
}

TEST_P(PoseRefinement, ExpectedLandmarksAreThoseInView) {
  MapKeyframe keyframe;
  keyframe.id = 0;
  map_.Put(keyframe);
  const Map unseen = map_;
  const auto observe = [this](const auto& of_id) {
    auto landmark = of_id.second;
    landmark.observations = {{0, static_cast<int32_t>(of_id.first.value)}};
    map_.Put(landmark);
  };
  for (const auto& of_id : unseen.points()) observe(of_id);
  for (const auto& of_id : unseen.lines()) observe(of_id);
  const ExpectedLandmarks all = CountExpected(map_, 0, T_w_c_, FeatureWorld::Camera(), truth_);
  EXPECT_GE(all.found, 9 * truth_.Weight() / 10) << "a line may end in the image and have its middle outside";
  EXPECT_LE(all.found, truth_.Weight());
  EXPECT_LT(all.expected, GetParam().points + 2 * GetParam().lines) << "some are behind the camera";
  Association half = truth_;
  for (size_t i = 0; i < half.points.size(); i += 2) half.points[i] = -1;
  for (size_t i = 0; i < half.lines.size(); i += 2) half.lines[i] = -1;
  EXPECT_NEAR(CountExpected(map_, 0, T_w_c_, FeatureWorld::Camera(), half).Share(), all.Share() / 2, 0.05);
  EXPECT_EQ(all.cells_shown, all.cells);
  const SE3 T_w_turned = T_w_c_ * SE3(ExpSO3(Eigen::Vector3d(0.0, 3.1, 0.0)), Eigen::Vector3d::Zero());
  EXPECT_LT(CountExpected(map_, 0, T_w_turned, FeatureWorld::Camera(), truth_).found, all.found / 4);
}

std::string Name(const testing::TestParamInfo<FeatureWorld::Counts>& counts) {
  return std::to_string(counts.param.points) + "Points" + std::to_string(counts.param.lines) + "Lines";
}

INSTANTIATE_TEST_SUITE_P(Kinds, PoseRefinement,
                         testing::Values(FeatureWorld::Counts{100, 0}, FeatureWorld::Counts{0, 60},
                                         FeatureWorld::Counts{80, 40}),
                         Name);

}  // namespace
}  // namespace plslam
