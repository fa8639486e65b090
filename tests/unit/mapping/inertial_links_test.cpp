// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/inertial_links.h"

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "core/files/archive.h"
#include "tests/unit/inertial/smooth_motion.h"

namespace plslam::mapping {
namespace {

constexpr double kStep_s = 0.4;

/// Keyframes of a session whose sensor senses all motions between them.
class Session {
 public:
  explicit Session(int n, double step_s = kStep_s) {
    for (int i = 0; i < n; ++i) {
      MapKeyframe keyframe;
      keyframe.id = i;
      keyframe.name = {SessionId(7), i};
      keyframe.previous_id = KeyframeId(int64_t{i} - 1);
      keyframe.t_ns = std::llround(1e9 * step_s * i);
      keyframe.T_w_kf = motion_.Pose(step_s * i);
      keyframe.up = UpDirection{keyframe.T_w_kf.R().transpose() * Eigen::Vector3d::UnitZ(), 0.004};
      map_.Put(keyframe);
      links_.Add(keyframe, Sensed(step_s * (i - 1), step_s * i), map_);
    }
  }

  InertialLinks& links() { return links_; }
  /// A keyframe at the end of this interval, after that of this number.
  void Add(int id, int previous_id, const InertialInterval& interval) {
    MapKeyframe keyframe;
    keyframe.id = id;
    keyframe.name = {SessionId(7), id};
    keyframe.previous_id = previous_id;
    keyframe.t_ns = interval.to_ns;
    links_.Add(keyframe, interval, map_);
  }

  /// The motions between these keyframes, as an adjustment gets them.
  std::vector<InertialMotion> Motions(const std::vector<KeyframeId>& keyframes) {
    MapBundle bundle;
    bundle.keyframes = keyframes;
    links_.AddTo(bundle, map_);
    gravity_ = bundle.problem.gravity;
    return bundle.problem.inertial_motions;
  }
  const GravityPrior& gravity() const { return gravity_; }
  void ForgetVertical() {
    const Map before = map_;
    for (const auto& [id, keyframe] : before.keyframes()) {
      MapKeyframe without = keyframe;
      without.up.reset();
      map_.Put(without);
    }
  }

  InertialInterval Sensed(double from_s, double to_s) const {
    InertialInterval interval;
    interval.from_ns = std::llround(1e9 * from_s);
    interval.to_ns = std::llround(1e9 * to_s);
    interval.samples = motion_.Samples(200.0, from_s, to_s);
    interval.bias = {ImuBias(), 1e-4, 0.02};
    return interval;
  }

 private:
  test::SmoothMotion motion_;
  Map map_;
  InertialLinks links_;
  GravityPrior gravity_;
};

TEST(InertialLinks, MotionsBetweenKeyframesOfTheBundle) {
  Session session(6);
  const auto motions = session.Motions({5, 4, 3, 1});
  ASSERT_EQ(motions.size(), 2U) << "3 to 4 and 4 to 5";
  EXPECT_EQ(std::pair(motions[0].a, motions[0].b), std::pair(2, 1));
  EXPECT_EQ(std::pair(motions[1].a, motions[1].b), std::pair(1, 0));
  for (const InertialMotion& motion : motions) EXPECT_NEAR(motion.sensed.dt_s(), kStep_s, 1e-9);
  EXPECT_LT((session.gravity().g_w_m_s2 - Eigen::Vector3d(0.0, 0.0, -9.81)).norm(), 1e-6);
}

TEST(InertialLinks, RemovedKeyframeJoinsItsLinks) {
  Session session(4);
  session.links().Remove(2);
  const auto motions = session.Motions({1, 3});
  ASSERT_EQ(motions.size(), 1U);
  EXPECT_NEAR(motions[0].sensed.dt_s(), 2.0 * kStep_s, 1e-9);
  session.links().Remove(1);
  const auto longer = session.Motions({0, 3});
  ASSERT_EQ(longer.size(), 1U);
  EXPECT_NEAR(longer[0].sensed.dt_s(), 3.0 * kStep_s, 1e-9);
  session.links().Remove(3);
  EXPECT_TRUE(session.Motions({0, 1, 2, 3}).empty());
}

TEST(InertialLinks, LongMotionsAreLeftOut) {
  Session session(3, 2.0);
  EXPECT_EQ(session.Motions({0, 1, 2}).size(), 2U);
  session.links().Remove(1);
  EXPECT_TRUE(session.Motions({0, 2}).empty()) << "4 s";
}

TEST(InertialLinks, NoneWithoutVertical) {
  Session session(3);
  session.ForgetVertical();
  EXPECT_TRUE(session.Motions({0, 1, 2}).empty());
}

TEST(InertialLinks, NoneFromMissingSamples) {
  Session session(3);
  InertialInterval cut = session.Sensed(2 * kStep_s, 3 * kStep_s);
  cut.samples.resize(cut.samples.size() / 2);
  session.Add(3, 2, cut);
  EXPECT_EQ(session.Motions({0, 1, 2, 3}).size(), 2U);
}

// The message of keyframe 3 was lost: that of 4 has what was sensed since 3.
TEST(InertialLinks, NoneAcrossAMissingKeyframe) {
  Session session(5);
  session.links().Remove(4);
  session.links().Remove(3);
  session.Add(4, 2, session.Sensed(3 * kStep_s, 4 * kStep_s));
  EXPECT_TRUE(session.Motions({2, 4}).empty());
  session.Add(4, 2, session.Sensed(2 * kStep_s, 4 * kStep_s));
  EXPECT_EQ(session.Motions({2, 4}).size(), 1U);
}

// A process that continues from the state of another one gives the same bits, whatever was integrated before.
TEST(InertialLinks, StoredOnesGiveTheSameBits) {
  Session session(5);
  (void)session.Motions({0, 1, 2, 3, 4});
  // A bias that moves out of the linear range: what was integrated is integrated again.
  InertialInterval biased = session.Sensed(4 * kStep_s, 5 * kStep_s);
  biased.bias.mean.rate_rad_s = {0.1, 0.0, 0.0};
  session.Add(5, 4, biased);
  const auto expected = session.Motions({0, 1, 2, 3, 4});
  const std::vector<uint8_t> bytes = archive::ToBytesOf(0, session.links());
  Session other(0);
  archive::FromBytes(bytes, other.links());
  Session restored(5);
  restored.links() = other.links();
  const auto motions = restored.Motions({0, 1, 2, 3, 4});
  ASSERT_EQ(motions.size(), expected.size());
  for (size_t i = 0; i < motions.size(); ++i) {
    EXPECT_EQ(motions[i].sensed.dv_m_s(), expected[i].sensed.dv_m_s());
    EXPECT_EQ(motions[i].sensed.dp_m(), expected[i].sensed.dp_m());
    EXPECT_EQ(motions[i].sensed.bias().rate_rad_s, expected[i].sensed.bias().rate_rad_s);
    EXPECT_EQ(motions[i].bias.mean.rate_rad_s, biased.bias.mean.rate_rad_s);
  }
}

}  // namespace
}  // namespace plslam::mapping
