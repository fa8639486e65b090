// SPDX-License-Identifier: BSD-3-Clause
// Semi-direct tracking: which frames are followed, and how well.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "tests/support/changed_images.h"
#include "tests/support/data_folder.h"
#include "tests/support/odometry_run.h"
#include "tests/support/worse_images.h"
#include "vo_process/stereo/feature_tracker.h"
#include "vo_process/stereo/stereo_front_end.h"
#include "vo_process/tracking/follow_policy.h"

namespace plslam::vo {
namespace {

struct Outcome {
  std::vector<test::OdometryFrame> frames;
  std::vector<bool> followed;

  int Followed() const { return static_cast<int>(std::count(followed.begin(), followed.end(), true)); }
  double Error_m() const { return test::AbsoluteTrajectoryError(frames); }
};

Outcome RunWith(const Dataset& dataset, FrontEnd front_end) {
  VoOptions options;
  options.tracking.front_end = front_end;
  Outcome run;
  run.frames = test::RunOdometry(
      dataset, options, 1, 1 << 30,
      [&](const StereoImages&, const OdometryResult& result) { run.followed.push_back(result.is_followed); });
  return run;
}

Outcome Follow(const std::string& world) { return RunWith(*OpenDataset(world, ""), FrontEnd::kSemiDirect); }

/// Leaves out one of seven frames.
class DroppedFrames : public test::ChangedImages {
 public:
  using ChangedImages::ChangedImages;
  int size() const override { return dataset_.size() * 6 / 7; }
  int64_t t_ns(int index) const override { return dataset_.t_ns(Kept(index)); }
  std::optional<SE3> GroundTruth(int index) const override { return dataset_.GroundTruth(Kept(index)); }
  StereoImages Read(int index) const override { return dataset_.Read(Kept(index)); }

 private:
  static int Kept(int index) { return index + index / 6; }
};

/// Every second pair has half of the brightness: light that flickers.
class FlickeringLight : public test::ChangedImages {
 public:
  using ChangedImages::ChangedImages;
  StereoImages Read(int index) const override {
    StereoImages images = dataset_.Read(index);
    if (index % 2 == 0) return images;
    images.left = 0.5 * images.left;
    images.right = 0.5 * images.right;
    return images;
  }
};

TEST(Following, MostFramesOfAWorldAreFollowed) {
  for (const char* world : {"room", "corridor", "street"}) {
    const auto dataset = OpenDataset(std::string("synthetic:") + world + "?size=320x240&frames=60", "");
    const Outcome followed = RunWith(*dataset, FrontEnd::kSemiDirect);
    const Outcome detected = RunWith(*dataset, FrontEnd::kDescriptors);
    EXPECT_GT(followed.Followed(), 25) << world;
    EXPECT_EQ(detected.Followed(), 0) << world;
    EXPECT_EQ(test::LostFrames(followed.frames), 0) << world;
    EXPECT_LT(followed.Error_m(), 1.5 * detected.Error_m()) << world;
  }
}

TEST(Following, ObeysItsPolicy) {
  const Outcome run = Follow("synthetic:room?size=320x240&frames=60");
  int in_a_row = 0;
  for (size_t i = 0; i < run.frames.size(); ++i) {
    in_a_row = run.followed[i] ? in_a_row + 1 : 0;
    EXPECT_LE(in_a_row, FollowPolicy::kMostFollowed) << i;
    EXPECT_FALSE(run.followed[i] && run.frames[i].keyframe) << i;
    EXPECT_FALSE(run.followed[i] && i < FollowPolicy::kSureFrames) << i;
  }
}

TEST(Following, NothingIsFollowedBesideMovingBodies) {
  const auto dataset = OpenDataset("synthetic:street?size=640x480&frames=25&bodies=2&body=lead", "");
  const Outcome run = RunWith(*dataset, FrontEnd::kSemiDirect);
  EXPECT_EQ(run.Followed(), 0);
}

/// Share of the road's points within 8 m that are found 0.6 m farther on; `with_slopes`: the surface is known to be a road.
double ShareOfRoadFound(bool with_slopes) {
  const auto dataset = OpenDataset("synthetic:street?size=640x480&frames=3", "");
  StereoFrontEnd front_end(dataset->rig(), VoOptions());
  const StereoCamera& camera = front_end.camera();
  StageTimer timer;
  front_end.Take(dataset->Read(0), timer);
  StereoFeatures features = front_end.Detect(timer);
  features.lines.clear();
  std::erase_if(features.points, [&](const StereoPoint& point) {
    if (!point.HasDepth()) return true;
    const Eigen::Vector3d p = camera.Backproject({point.left.px.x(), point.left.px.y(), point.disparity_px});
    return p.z() > 8.0 || p.y() < 1.0;
  });
  if (!with_slopes) {
    for (StereoPoint& point : features.points) point.disparity_slope.setZero();
  }
  FeatureTracker tracker(camera, StereoOptions());
  tracker.Begin(front_end.pair().left, features);
  const SE3 before = *dataset->GroundTruth(0);
  const SE3 now = *dataset->GroundTruth(2);
  tracker.SetPose(before);
  front_end.Take(dataset->Read(2), timer);
  front_end.Follow(timer, {}, before, now, tracker);
  return tracker.Share();
}

TEST(Following, SlopesOfTheRoadAreKnown) {
  const double with = ShareOfRoadFound(true);
  const double without = ShareOfRoadFound(false);
  EXPECT_GT(with, 0.5);
  EXPECT_LT(without, 0.7 * with);
}

// A robot that starts to turn, or hits a kerb: 30 pixels away from where the features are expected.
TEST(Following, UnexpectedTurnsAreFound) {
  const auto dataset = OpenDataset("synthetic:room?size=640x480&frames=2", "");
  StereoFrontEnd front_end(dataset->rig(), VoOptions());
  StageTimer timer;
  front_end.Take(dataset->Read(0), timer);
  FeatureTracker tracker(front_end.camera(), StereoOptions());
  tracker.Begin(front_end.pair().left, front_end.Detect(timer));
  const SE3 before = *dataset->GroundTruth(0);
  tracker.SetPose(before);
  Vector6d turn = Vector6d::Zero();
  turn.tail<3>() = 30.0 / front_end.camera().f_px * Eigen::Vector3d(-0.6, 0.8, 0.1);
  front_end.Take(dataset->Read(1), timer);
  front_end.Follow(timer, {}, before, *dataset->GroundTruth(1) * SE3::Exp(turn), tracker);
  EXPECT_GT(tracker.Share(), 0.7);
}

// Features of a depth camera are followed into an image without depth, and into a black one.
TEST(Following, DepthIsThatOfThePresentImage) {
  PLSLAM_REQUIRE_DATA(folder, "tum_fr1_xyz");
  const auto dataset = OpenDataset(folder.string(), "");
  StereoFrontEnd front_end(dataset->rig(), VoOptions());
  StageTimer timer;
  front_end.Take(dataset->Read(0), timer);
  const StereoFeatures features = front_end.Detect(timer);
  const auto follow = [&](const StereoImages& images) {
    FeatureTracker tracker(front_end.camera(), StereoOptions());
    front_end.Take(dataset->Read(0), timer);
    tracker.Begin(front_end.pair().left, features);
    front_end.Take(images, timer);
    return front_end.Follow(timer, {}, SE3(), SE3(), tracker);
  };
  const auto with_depth = [](const StereoFeatures& seen) {
    return std::ranges::count_if(seen.points, [](const StereoPoint& point) { return point.HasDepth(); });
  };
  StereoImages images = dataset->Read(0);
  const StereoFeatures same = follow(images);
  EXPECT_GT(with_depth(same), 50);
  EXPECT_GT(same.lines.size(), 3U);
  images.right.setTo(0);
  const StereoFeatures without = follow(images);
  EXPECT_GT(without.points.size(), 50U);
  EXPECT_EQ(with_depth(without), 0);
  EXPECT_TRUE(without.lines.empty());
  images = dataset->Read(0);
  images.left.setTo(0);
  const StereoFeatures black = follow(images);
  EXPECT_TRUE(black.points.empty());
  EXPECT_TRUE(black.lines.empty());
}

TEST(Following, LightMayFlicker) {
  const auto dataset = OpenDataset("synthetic:room?size=320x240&frames=60", "");
  const FlickeringLight flickering(*dataset);
  const Outcome run = RunWith(flickering, FrontEnd::kSemiDirect);
  EXPECT_GT(run.Followed(), 20);
  EXPECT_EQ(test::LostFrames(run.frames), 0);
  EXPECT_LT(run.Error_m(), 1.5 * RunWith(flickering, FrontEnd::kDescriptors).Error_m());
}

TEST(Following, FramesMayBeMissing) {
  const auto dataset = OpenDataset("synthetic:room?size=320x240&frames=70", "");
  const DroppedFrames dropped(*dataset);
  const Outcome run = RunWith(dropped, FrontEnd::kSemiDirect);
  EXPECT_GT(run.Followed(), 20);
  EXPECT_EQ(test::LostFrames(run.frames), 0);
  EXPECT_LT(run.Error_m(), 1.5 * RunWith(dropped, FrontEnd::kDescriptors).Error_m());
}

TEST(Following, TheCameraMayTurnOnTheSpot) {
  const auto dataset = OpenDataset("synthetic:room?size=320x240&frames=60&turning=1", "");
  const Outcome run = RunWith(*dataset, FrontEnd::kSemiDirect);
  EXPECT_GT(run.Followed(), 10);
  EXPECT_EQ(test::LostFrames(run.frames), 0);
  EXPECT_LT(run.Error_m(), 1.5 * RunWith(*dataset, FrontEnd::kDescriptors).Error_m() + 1e-3);
}

TEST(Following, DarknessEndsIt) {
  const auto dataset = OpenDataset("synthetic:room?size=320x240&frames=40", "");
  const test::WorseImages black(*dataset, {.black_first = 20, .black_count = 3});
  const Outcome run = RunWith(black, FrontEnd::kSemiDirect);
  for (size_t i = 20; i < 23 + FollowPolicy::kSureFrames; ++i) EXPECT_FALSE(run.followed[i]) << i;
  EXPECT_EQ(test::LostFrames(run.frames), 3);
  EXPECT_GT(run.Followed(), 10);
}

}  // namespace
}  // namespace plslam::vo
