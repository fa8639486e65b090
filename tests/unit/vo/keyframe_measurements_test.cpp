// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/keyframe_measurements.h"

#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/vo/small_scene.h"

namespace plslam::vo {
namespace {

using test::kCamera;
using test::kSigma_px;
using test::LandmarksOf;
using test::LineError;
using test::MakeScene;
using test::PointError;
using test::Scene;
using test::See;
using test::SeeLine;
using test::SeePoint;

/// Share of the variance that all frames have in common, as the keyframe states it.
constexpr double kCommonShare = 0.3;

double Shrink(int n) { return std::sqrt(kCommonShare + (1.0 - kCommonShare) / n); }

/// Forwards, sideways, and turning about all axes.
SE3 TrueAt(int frame) {
  return SE3(ExpSO3(0.01 * frame * Eigen::Vector3d(0.3, -0.2, 1.0)), 0.02 * frame * Eigen::Vector3d(1.0, -0.5, 1.5));
}

KeyframeContent ContentOf(const TrackedFrame& frame) {
  return {frame.features, frame.point_tracks, frame.line_tracks};
}

class KeyframeMeasurementsByDepth : public testing::TestWithParam<bool> {};

TEST_P(KeyframeMeasurementsByDepth, ExactMeasurementsStayExact) {
  const bool depth = GetParam();
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  constexpr int kFrames = 6;
  std::optional<TrackedFrame> last;
  for (int k = 1; k <= kFrames; ++k) {
    last = See(scene, TrueAt(k), {.seed = static_cast<uint32_t>(k), .depth = depth, .cut = true});
    measurements.Add(TrueAt(k), *last);
  }
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(*last));
  ASSERT_EQ(content.features.points.size(), scene.points.size());
  ASSERT_EQ(content.features.lines.size(), scene.lines.size());
  for (size_t i = 0; i < scene.points.size(); ++i) {
    const StereoPoint& seen = content.features.points[i];
    EXPECT_LT(PointError(seen, scene.points[i], TrueAt(kFrames)).head(depth ? 3 : 2).norm(), 1e-9) << "point " << i;
    EXPECT_EQ(seen.HasDepth(), depth);
    EXPECT_NEAR(seen.sigma_px, kSigma_px * Shrink(kFrames), 1e-12);
    EXPECT_NEAR(seen.sigma_disparity_px, kSigma_px * (depth ? Shrink(kFrames) : 1.0), 1e-12);
  }
  for (size_t i = 0; i < scene.lines.size(); ++i) {
    const StereoLine& seen = content.features.lines[i];
    const Segment2& own = last->features.lines[i].left.segment;
    EXPECT_LT(LineError(seen, scene.lines[i], TrueAt(kFrames)).head(depth ? 4 : 2).norm(), 1e-8) << "line " << i;
    EXPECT_LT((seen.left.segment.p - own.p).norm() + (seen.left.segment.q - own.q).norm(), 1e-9) << "line " << i;
    EXPECT_EQ(seen.HasDepth(), depth);
    EXPECT_NEAR(seen.sigma_px, kSigma_px * Shrink(kFrames), 1e-12);
    EXPECT_NEAR(seen.sigma_disparity_q_px, kSigma_px * (depth ? Shrink(kFrames) : 1.0), 1e-12);
  }
}

INSTANTIATE_TEST_SUITE_P(Depth, KeyframeMeasurementsByDepth, testing::Bool(),
                         [](const auto& kind) { return kind.param ? "WithDisparity" : "WithoutDisparity"; });

TEST(KeyframeMeasurements, PointsAreTheAverageOfTheErrorsOfAllFrames) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  constexpr int kFrames = 9;
  std::vector<Eigen::Vector3d> average(scene.points.size(), Eigen::Vector3d::Zero());
  std::optional<TrackedFrame> last;
  for (int k = 1; k <= kFrames; ++k) {
    last = See(scene, TrueAt(k), {.noise_px = kSigma_px, .seed = static_cast<uint32_t>(k)});
    measurements.Add(TrueAt(k), *last);
    for (size_t i = 0; i < average.size(); ++i) {
      average[i] += PointError(last->features.points[i], scene.points[i], TrueAt(k)) / kFrames;
    }
  }
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(*last));
  for (size_t i = 0; i < average.size(); ++i) {
    const Eigen::Vector3d error = PointError(content.features.points[i], scene.points[i], TrueAt(kFrames));
    EXPECT_LT((error - average[i]).norm(), 1e-9) << error.transpose() << " instead of " << average[i].transpose();
  }
}

TEST(KeyframeMeasurements, CertainMeasurementsHaveMoreWeight) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  TrackedFrame off = See(scene, TrueAt(1));
  for (StereoPoint& point : off.features.points) {
    point.left.px.x() += 1.0;
    point.sigma_px *= 3.0;
  }
  measurements.Add(TrueAt(1), off);
  const TrackedFrame last = See(scene, TrueAt(2));
  measurements.Add(TrueAt(2), last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_NEAR(PointError(content.features.points[i], scene.points[i], TrueAt(2)).x(), 0.1, 1e-9);
  }
}

TEST(KeyframeMeasurements, NoiseOfLinesFallsWithTheNumberOfFrames) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  constexpr int kFrames = 9;
  Eigen::Array4d one_frame = Eigen::Array4d::Zero();
  Eigen::Array4d mean = Eigen::Array4d::Zero();
  for (uint32_t run = 0; run < 40; ++run) {
    KeyframeMeasurements measurements(kCamera);
    std::optional<TrackedFrame> last;
    for (int k = 1; k <= kFrames; ++k) {
      last = See(scene, TrueAt(k), {.noise_px = kSigma_px, .seed = 100 * run + static_cast<uint32_t>(k)});
      measurements.Add(TrueAt(k), *last);
    }
    const KeyframeContent content = measurements.Take(landmarks, ContentOf(*last));
    for (size_t i = 0; i < scene.lines.size(); ++i) {
      one_frame += LineError(last->features.lines[i], scene.lines[i], TrueAt(kFrames)).array().square();
      mean += LineError(content.features.lines[i], scene.lines[i], TrueAt(kFrames)).array().square();
    }
  }
  const Eigen::Array4d ratio = (mean / one_frame).sqrt();
  EXPECT_LT((ratio - 1.0 / std::sqrt(1.0 * kFrames)).abs().maxCoeff(), 0.08) << ratio.transpose();
}

TEST(KeyframeMeasurements, AddsFeaturesMissedInTheKeyframe) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  // Point 5 and line 5 are seen once only, which is not enough.
  measurements.Add(TrueAt(1), See(scene, TrueAt(1)));
  for (int k = 2; k <= 3; ++k) {
    measurements.Add(TrueAt(k), See(scene, TrueAt(k), {.cut = true, .missed_points = {5}, .missed_lines = {5}}));
  }
  const TrackedFrame last = See(scene, TrueAt(4), {.missed_points = {3, 5, 7}, .missed_lines = {2, 5}});
  measurements.Add(TrueAt(4), last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  ASSERT_EQ(content.features.points.size(), last.features.points.size() + 2);
  ASSERT_EQ(content.features.lines.size(), last.features.lines.size() + 1);
  ASSERT_EQ(content.point_tracks.size(), content.features.points.size());
  ASSERT_EQ(content.line_tracks.size(), content.features.lines.size());
  for (const size_t added : {0u, 1u}) {
    const size_t place = last.features.points.size() + added;
    const int id = added == 0 ? 3 : 7;
    EXPECT_EQ(content.point_tracks[place].landmark_id, id);
    const StereoPoint& seen = content.features.points[place];
    EXPECT_LT(PointError(seen, scene.points[static_cast<size_t>(id)], TrueAt(4)).norm(), 1e-9) << "point " << id;
    EXPECT_NEAR(seen.sigma_px, kSigma_px * Shrink(3), 1e-12);
  }
  EXPECT_EQ(content.line_tracks.back().landmark_id, 2);
  const StereoLine& seen = content.features.lines.back();
  EXPECT_LT(LineError(seen, scene.lines[2], TrueAt(4)).norm(), 1e-8) << LineError(seen, scene.lines[2], TrueAt(4));
  EXPECT_TRUE(seen.HasDepth());
  EXPECT_NEAR(seen.sigma_px, kSigma_px * Shrink(3), 1e-12);
  const Eigen::Vector2d p = kCamera.Project(TrueAt(4).Inverse() * scene.lines[2].p);
  EXPECT_LT((seen.left.segment.p - p).norm(), 1e-9) << "directed and cut as the landmark is";
}

/// As `See`, followed from the previous frame.
TrackedFrame Follow(const Scene& scene, const SE3& T_odom_c, double off_px) {
  TrackedFrame frame = See(scene, T_odom_c);
  frame.is_followed = true;
  for (StereoPoint& point : frame.features.points) point.left.px.x() += off_px;
  return frame;
}

TEST(KeyframeMeasurements, DetectionsCountOnceEach) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  TrackedFrame off = Follow(scene, TrueAt(1), 1.0);
  off.is_followed = false;
  measurements.Add(TrueAt(1), off);
  for (int k = 2; k <= 4; ++k) measurements.Add(TrueAt(k), Follow(scene, TrueAt(k), 1.0));
  const TrackedFrame last = See(scene, TrueAt(5));
  measurements.Add(TrueAt(5), last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_NEAR(PointError(content.features.points[i], scene.points[i], TrueAt(5)).x(), 0.5, 1e-9);
    EXPECT_NEAR(content.features.points[i].sigma_px, kSigma_px * Shrink(2), 1e-12);
  }
}

TEST(KeyframeMeasurements, ErrorsOfTheLastKeyframeAreLeftOut) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  const TrackedFrame keyframe = See(scene, TrueAt(1));
  measurements.Add(TrueAt(1), keyframe);
  measurements.Take(landmarks, ContentOf(keyframe));
  for (int k = 2; k <= 3; ++k) measurements.Add(TrueAt(k), Follow(scene, TrueAt(k), 1.0));
  const TrackedFrame last = See(scene, TrueAt(4));
  measurements.Add(TrueAt(4), last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_LT(PointError(content.features.points[i], scene.points[i], TrueAt(4)).norm(), 1e-9);
    EXPECT_NEAR(content.features.points[i].sigma_px, kSigma_px, 1e-12);
  }
}

// Its position would be that of its only detection, moved by odometry. Lines are located in each frame.
TEST(KeyframeMeasurements, PointOfOneDetectionIsNotAdded) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  measurements.Add(TrueAt(1), See(scene, TrueAt(1)));
  for (int k = 2; k <= 4; ++k) measurements.Add(TrueAt(k), Follow(scene, TrueAt(k), 0.0));
  const TrackedFrame last = See(scene, TrueAt(5), {.missed_points = {3}, .missed_lines = {2}});
  measurements.Add(TrueAt(5), last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  EXPECT_EQ(content.features.points.size(), scene.points.size() - 1);
  EXPECT_EQ(content.features.lines.size(), scene.lines.size());
}

// Disparities of an added line are measured, not the landmark's, even if only one frame had them.
TEST(KeyframeMeasurements, AddedLineHasItsMeasuredDisparity) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  measurements.Add(TrueAt(1), See(scene, TrueAt(1), {.depth = false}));
  TrackedFrame near = See(scene, TrueAt(2));
  for (StereoLine& line : near.features.lines) {
    line.disparity_p_px += 0.5;
    line.disparity_q_px += 0.5;
  }
  measurements.Add(TrueAt(2), near);
  const TrackedFrame last = See(scene, TrueAt(3), {.missed_lines = {4}});
  measurements.Add(TrueAt(3), last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  ASSERT_EQ(content.line_tracks.back().landmark_id, 4);
  const Eigen::Vector4d error = LineError(content.features.lines.back(), scene.lines[4], TrueAt(3));
  EXPECT_LT((error - Eigen::Vector4d(0.0, 0.0, 0.5, 0.5)).norm(), 0.02) << error.transpose();
  EXPECT_NEAR(content.features.lines.back().sigma_disparity_p_px, kSigma_px, 1e-12);
}

TEST(KeyframeMeasurements, FeaturesWithoutALandmarkAreUnchanged) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  std::optional<TrackedFrame> last;
  for (int k = 1; k <= 4; ++k) {
    last = See(scene, TrueAt(k), {.noise_px = 1.0, .seed = static_cast<uint32_t>(k)});
    // Without a landmark, or of one that has been dropped since.
    for (FeatureTrack& track : last->point_tracks) track.landmark_id = track.landmark_id.value % 2 == 0 ? -1 : 1000;
    for (FeatureTrack& track : last->line_tracks) track.landmark_id = track.landmark_id.value % 2 == 0 ? -1 : 1000;
    measurements.Add(TrueAt(k), *last);
  }
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(*last));
  ASSERT_EQ(content.features.points.size(), scene.points.size());
  ASSERT_EQ(content.features.lines.size(), scene.lines.size());
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_EQ(content.features.points[i].left.px, last->features.points[i].left.px);
    EXPECT_EQ(content.features.points[i].disparity_px, last->features.points[i].disparity_px);
    EXPECT_EQ(content.features.points[i].sigma_px, kSigma_px);
  }
  for (size_t i = 0; i < scene.lines.size(); ++i) {
    EXPECT_EQ(content.features.lines[i].left.segment.p, last->features.lines[i].left.segment.p);
    EXPECT_EQ(content.features.lines[i].disparity_q_px, last->features.lines[i].disparity_q_px);
    EXPECT_EQ(content.features.lines[i].sigma_px, kSigma_px);
  }
}

// The landmark's position cancels out for a static camera: the measurement is the same wherever the landmark is.
TEST(KeyframeMeasurements, StandingCameraNeedsNoLandmarkPosition) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene, {0.02, -0.01, 0.05});
  KeyframeMeasurements measurements(kCamera);
  const TrackedFrame frame = See(scene, TrueAt(1));
  for (int k = 0; k < 5; ++k) measurements.Add(TrueAt(1), frame);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(frame));
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_LT(PointError(content.features.points[i], scene.points[i], TrueAt(1)).norm(), 1e-9) << "point " << i;
  }
  for (size_t i = 0; i < scene.lines.size(); ++i) {
    EXPECT_LT(LineError(content.features.lines[i], scene.lines[i], TrueAt(1)).norm(), 1e-8) << "line " << i;
  }
}

TEST(KeyframeMeasurements, FramesOfAStandingCameraAreForgotten) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  for (uint32_t k = 0; k < 50; ++k) {
    measurements.Add(TrueAt(1), See(scene, TrueAt(1), {.noise_px = 5.0, .seed = k}));
  }
  const TrackedFrame exact = See(scene, TrueAt(1));
  for (size_t k = 0; k < KeyframeMeasurements::kMaxFrames; ++k) measurements.Add(TrueAt(1), exact);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(exact));
  for (size_t i = 0; i < scene.points.size(); ++i) {
    EXPECT_LT(PointError(content.features.points[i], scene.points[i], TrueAt(1)).norm(), 1e-9) << "point " << i;
  }
}

TEST(KeyframeMeasurements, LandmarksOutOfViewAreNotAdded) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  const SE3 behind(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.0, 0.0, 20.0));
  const SE3 aside(ExpSO3(Eigen::Vector3d(0.0, 1.4, 0.0)), Eigen::Vector3d::Zero());
  for (const SE3& T_odom_c : {behind, aside}) {
    KeyframeMeasurements measurements(kCamera);
    for (int k = 1; k <= 3; ++k) measurements.Add(TrueAt(k), See(scene, TrueAt(k)));
    // A feature that was taken for landmark 0 stays as it is.
    StereoFeatures wrong;
    wrong.points.push_back(SeePoint({100.0, 50.0, 7.0}, true));
    wrong.lines.push_back(SeeLine({100.0, 50.0, 7.0}, {150.0, 90.0, 7.0}, true));
    TrackedFrame last(wrong);
    last.point_tracks[0].landmark_id = last.line_tracks[0].landmark_id = 0;
    measurements.Add(T_odom_c, last);
    const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
    ASSERT_EQ(content.features.points.size(), 1u);
    ASSERT_EQ(content.features.lines.size(), 1u);
    EXPECT_TRUE(kCamera.InImage(content.features.points[0].left.px, 0.0));
    EXPECT_TRUE(kCamera.InImage(content.features.lines[0].left.segment.p, 0.0));
    if (T_odom_c.translation().z() < 1.0) continue;
    EXPECT_EQ(content.features.points[0].left.px, wrong.points[0].left.px);
    EXPECT_EQ(content.features.lines[0].left.segment.q, wrong.lines[0].left.segment.q);
  }
}

TEST(KeyframeMeasurements, EndsOfAddedLinesStayInTheImageAndOnTheLine) {
  // Turned so far that the lines cross the right border.
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  int cut = 0;
  for (const double turn : {-0.55, -0.6, -0.65}) {
    const SE3 T_odom_c(ExpSO3(Eigen::Vector3d(0.25, turn, 0.3)), Eigen::Vector3d::Zero());
    KeyframeMeasurements measurements(kCamera);
    for (int k = 1; k <= 3; ++k) measurements.Add(TrueAt(k), See(scene, TrueAt(k)));
    const TrackedFrame last{StereoFeatures{}};
    measurements.Add(T_odom_c, last);
    const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
    for (size_t i = 0; i < content.features.lines.size(); ++i) {
      const StereoLine& seen = content.features.lines[i];
      const Segment3& truth = scene.lines[static_cast<size_t>(content.line_tracks[i].landmark_id.value)];
      EXPECT_TRUE(kCamera.InImage(seen.left.segment.p, 0.0)) << seen.left.segment.p.transpose();
      EXPECT_TRUE(kCamera.InImage(seen.left.segment.q, 0.0)) << seen.left.segment.q.transpose();
      EXPECT_LT(LineError(seen, truth, T_odom_c).head<2>().norm(), 1e-8) << "turn " << turn << " line " << i;
      const SE3 T_c_odom = T_odom_c.Inverse();
      cut += kCamera.InImage(kCamera.Project(T_c_odom * truth.p), 0.0) &&
                     kCamera.InImage(kCamera.Project(T_c_odom * truth.q), 0.0)
                 ? 0
                 : 1;
    }
  }
  EXPECT_GT(cut, 5);
}

TEST(KeyframeMeasurements, EndsOfItsOwnLinesStayInTheImage) {
  // A tilted line that was seen too far to the right so far ends at the image's left border.
  const SE3 T_odom_c;
  Scene scene;
  scene.lines.push_back({kCamera.Backproject({0.2, 100.0, 10.0}), kCamera.Backproject({60.0, 250.0, 10.0})});
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  const TrackedFrame exact = See(scene, T_odom_c);
  measurements.Add(T_odom_c, exact);
  TrackedFrame last = exact;
  for (Eigen::Vector2d* end : {&last.features.lines[0].left.segment.p, &last.features.lines[0].left.segment.q}) {
    *end += Eigen::Vector2d(0.0, -3.0);
  }
  measurements.Add(T_odom_c, last);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(last));
  const Segment2& segment = content.features.lines[0].left.segment;
  EXPECT_TRUE(kCamera.InImage(segment.p, 0.0)) << segment.p.transpose();
  EXPECT_NE(segment.p, last.features.lines[0].left.segment.p);
}

TEST(KeyframeMeasurements, MeasurementsAreClearedByTake) {
  const Scene scene = MakeScene();
  const LocalLandmarks landmarks = LandmarksOf(scene);
  KeyframeMeasurements measurements(kCamera);
  for (uint32_t k = 1; k <= 3; ++k) {
    measurements.Add(TrueAt(1), See(scene, TrueAt(1), {.noise_px = 3.0, .seed = k}));
  }
  measurements.Take(landmarks, ContentOf(See(scene, TrueAt(1))));
  const TrackedFrame next = See(scene, TrueAt(2), {.missed_points = {1}, .missed_lines = {1}});
  measurements.Add(TrueAt(2), next);
  const KeyframeContent content = measurements.Take(landmarks, ContentOf(next));
  ASSERT_EQ(content.features.points.size(), scene.points.size() - 1);
  ASSERT_EQ(content.features.lines.size(), scene.lines.size() - 1);
  for (size_t i = 0; i < content.features.points.size(); ++i) {
    EXPECT_EQ(content.features.points[i].left.px, next.features.points[i].left.px);
    EXPECT_EQ(content.features.points[i].sigma_px, kSigma_px);
  }
  EXPECT_EQ(content.features.lines[3].left.segment.p, next.features.lines[3].left.segment.p);
}

TEST(KeyframeMeasurements, NothingCollectedChangesNothing) {
  const Scene scene = MakeScene();
  KeyframeMeasurements measurements(kCamera);
  const TrackedFrame frame = See(scene, TrueAt(1));
  const KeyframeContent content = measurements.Take(LandmarksOf(scene), ContentOf(frame));
  ASSERT_EQ(content.features.points.size(), frame.features.points.size());
  EXPECT_EQ(content.features.points[0].left.px, frame.features.points[0].left.px);
}

}  // namespace
}  // namespace plslam::vo
