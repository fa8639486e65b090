// SPDX-License-Identifier: BSD-3-Clause
// Samples of an inertial sensor between keyframes.
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/datasets/open_dataset.h"
#include "core/inertial/inertial_filter.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

struct SensedKeyframe {
  int frame = 0;
  int64_t t_ns = 0;
  InertialInterval interval;
};

double Zero() { return 0.0; }

/// Returns the intervals of all keyframes. `are_sent`: whether the samples that lead to a frame arrive.
std::vector<SensedKeyframe> KeyframesOf(const Dataset& dataset, const std::function<bool(int)>& are_sent) {
  VoOptions options;
  StereoFrontEnd front_end(dataset.rig(), options);
  Odometry odometry(front_end.camera(), options, RollingShutter(), MountedImuOf(dataset.rig()));
  std::vector<SensedKeyframe> keyframes;
  int64_t last_t_ns = 0;
  for (int i = 0; i < dataset.size(); ++i) {
    StageTimer timer(Zero);
    const StereoImages images = dataset.Read(i);
    const int64_t offset_ns = dataset.rig().imu ? dataset.rig().imu->offset_ns() : 0;
    const auto samples = SamplesOfMotion(dataset.ImuSamples(), last_t_ns - offset_ns, images.t_ns - offset_ns);
    odometry.ExpectImu(are_sent(i) ? samples : samples.first(0), last_t_ns, images.t_ns);
    last_t_ns = images.t_ns;
    const OdometryResult result = odometry.Track(images.t_ns, odometry.SeePair(front_end, images, timer));
    if (result.keyframe) keyframes.push_back({i, images.t_ns, result.keyframe->inertial});
  }
  return keyframes;
}

std::vector<SensedKeyframe> KeyframesOf(const std::function<bool(int)>& are_sent) {
  return KeyframesOf(*OpenDataset("synthetic:room?imu=200&size=320x240&frames=100", ""), are_sent);
}

TEST(KeyframeInterval, ReachesFromKeyframeToKeyframe) {
  const auto dataset = OpenDataset("synthetic:room?imu=200&size=320x240&frames=100", "");
  const std::vector<SensedKeyframe> keyframes = KeyframesOf(*dataset, [](int) { return true; });
  const SE3 T_c_imu = MountedImuOf(dataset->rig())->T_imu_c.Inverse();
  int n_known = 0;
  for (size_t k = 1; k < keyframes.size(); ++k) {
    const InertialInterval& interval = keyframes[k].interval;
    if (interval.empty()) continue;
    ++n_known;
    EXPECT_EQ(interval.from_ns, keyframes[k - 1].t_ns);
    EXPECT_EQ(interval.to_ns, keyframes[k].t_ns);
    EXPECT_GT(interval.bias.force_sigma_m_s2, 0.0);
    const auto sensed = interval.Motion();
    ASSERT_TRUE(sensed) << k;
    const SE3 before = *dataset->GroundTruth(keyframes[k - 1].frame) * T_c_imu;
    const SE3 after = *dataset->GroundTruth(keyframes[k].frame) * T_c_imu;
    const SE3 off((before.Inverse() * after).rotation().conjugate() * sensed->dR(), Eigen::Vector3d::Zero());
    EXPECT_LT(off.Log().norm(), 0.002) << k;
  }
  EXPECT_GE(n_known, 5);
  EXPECT_TRUE(keyframes.front().interval.empty()) << "there is no keyframe before it";
}

TEST(KeyframeInterval, EmptyWhereSamplesAreMissing) {
  const std::vector<SensedKeyframe> all = KeyframesOf([](int) { return true; });
  const int missing = all[all.size() - 3].frame + 1;
  const std::vector<SensedKeyframe> keyframes = KeyframesOf([missing](int frame) { return frame != missing; });
  int n_empty = 0, n_known = 0;
  for (size_t k = 1; k < keyframes.size(); ++k) {
    const bool misses = keyframes[k - 1].frame < missing && missing <= keyframes[k].frame;
    EXPECT_TRUE(!misses || keyframes[k].interval.empty()) << k;
    n_empty += misses ? 1 : 0;
    n_known += keyframes[k].interval.empty() ? 0 : 1;
  }
  EXPECT_EQ(n_empty, 1);
  EXPECT_GE(n_known, 3);
}

TEST(KeyframeInterval, EmptyWithoutSensor) {
  const auto dataset = OpenDataset("synthetic:room?size=320x240&frames=30", "");
  for (const SensedKeyframe& keyframe : KeyframesOf(*dataset, [](int) { return true; }))
    EXPECT_TRUE(keyframe.interval.empty());
}

}  // namespace
}  // namespace plslam::vo
