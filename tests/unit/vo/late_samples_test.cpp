// SPDX-License-Identifier: BSD-3-Clause
// Samples of an inertial sensor that come late, are lost, or belong to frames that say nothing of motions.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "vo_process/tracking/motion/inertial_motion_model.h"

namespace plslam::vo {
namespace {

constexpr int64_t kNever = int64_t{1} << 60;
constexpr int kKnown = 40;  // frames, two seconds

/// True poses of a world, with samples that arrive when a test says.
class Fed {
 public:
  /// `delay_ns`: of the sample at this time after the first frame; kNever if it is lost.
  explicit Fed(std::function<int64_t(int64_t)> delay_ns = nullptr, int frames = 120)
      : dataset_(OpenDataset("synthetic:room?imu=200&size=320x240&frames=" + std::to_string(frames), "")),
        delay_ns_(std::move(delay_ns)),
        model(MountedImuOf(dataset_->rig())) {
    model.Start(SE3());
  }

  int size() const { return dataset_->size(); }
  int64_t t_ns(int frame) const { return dataset_->t_ns(frame); }
  SE3 Pose(int frame) const { return dataset_->GroundTruth(0)->Inverse() * *dataset_->GroundTruth(frame); }
  /// Expects a frame with the samples that have arrived a period of them after it.
  void Expect(int frame) {
    std::vector<ImuSample> arrived;
    for (const ImuSample& sample : dataset_->ImuSamples()) {
      const int64_t delay_ns = delay_ns_ ? delay_ns_(sample.t_ns - t_ns(0)) : 0;
      if (sample.t_ns + delay_ns <= t_ns(frame) + 5'000'000) arrived.push_back(sample);
    }
    const int64_t needed_ns = model.NeededFrom(t_ns(frame - 1));
    model.Expect(SamplesOfMotion(arrived, needed_ns, t_ns(frame)), t_ns(frame - 1), t_ns(frame));
  }
  void Observe(int frame, bool jumped = false) { Observe(Pose(frame), jumped); }
  void Observe(const SE3& T_odom_c, bool jumped = false) {
    model.Observe(T_odom_c, 1e-7 * Matrix6d::Identity(), true, jumped);
  }
  void Run(int first, int last) {
    for (int i = first; i <= last; ++i) {
      Expect(i);
      Observe(i);
    }
  }
  bool Predicts() const { return model.Predict(MotionPrediction()).by_robot; }
  double UpError(int frame) const {
    const Eigen::Vector3d truth = dataset_->GroundTruth(frame)->rotation().conjugate() * Eigen::Vector3d::UnitZ();
    return std::acos(std::min(1.0, truth.dot(model.Up()->direction)));
  }

 private:
  std::unique_ptr<Dataset> dataset_;
  std::function<int64_t(int64_t)> delay_ns_;

 public:
  InertialMotionModel model;
};

TEST(LateSamples, BurstsOfSixtyMillisecondsCostFewFrames) {
  // Every second, nothing arrives for 60 ms.
  constexpr int64_t kSecond_ns = 1'000'000'000, kBurst_ns = 60'000'000;
  Fed fed([](int64_t t_ns) {
    const int64_t since_ns = (t_ns + kSecond_ns - 500'000'000) % kSecond_ns;
    return since_ns < kBurst_ns ? kBurst_ns - since_ns : 0;
  });
  int n_predicted = 0, n_late = 0;
  for (int i = 1; i < fed.size(); ++i) {
    fed.Expect(i);
    if (i >= kKnown) {
      n_predicted += fed.Predicts() ? 1 : 0;
      n_late += fed.Predicts() ? 0 : 1;
    }
    fed.Observe(i);
    if (i >= kKnown) {
      ASSERT_TRUE(fed.model.Up()) << i;
      EXPECT_LT(fed.UpError(i), 1.5 * kRadPerDeg) << i;
    }
  }
  EXPECT_GT(n_late, 0);
  EXPECT_GE(n_predicted, 0.9 * (fed.size() - kKnown));
  EXPECT_LT(fed.model.normalised_innovation(), 2.0);
}

TEST(LateSamples, LostOnesLeaveTheVertical) {
  constexpr int64_t kFrom_ns = 3'000'000'000, kTo_ns = 3'300'000'000;
  Fed fed([](int64_t t_ns) { return t_ns > kFrom_ns && t_ns < kTo_ns ? kNever : 0; });
  int n_without = 0;
  for (int i = 1; i < fed.size(); ++i) {
    fed.Expect(i);
    fed.Observe(i);
    if (i < kKnown) continue;
    ASSERT_TRUE(fed.model.Up()) << i;
    EXPECT_LT(fed.UpError(i), 1.5 * kRadPerDeg) << i;
    EXPECT_LT(fed.UpError(i), 4.0 * fed.model.Up()->sigma_rad) << i;
    n_without += fed.model.IsTrusted() ? 0 : 1;
  }
  EXPECT_GE(n_without, 6) << "the velocity is not known";
  EXPECT_LE(n_without, 12) << "it is known soon after";
  EXPECT_LT(fed.model.normalised_innovation(), 2.0);
}

TEST(LateSamples, ThoseOfUnseenFramesAreTakenWhenTheyCome) {
  Fed fed([](int64_t t_ns) { return t_ns > 2'960'000'000 && t_ns < 3'200'000'000 ? 250'000'000 : 0; });
  fed.Run(1, 59);
  for (int i = 60; i < 69; ++i) {
    fed.Expect(i);
    fed.model.Miss();
    EXPECT_TRUE(!fed.model.IsTrusted() || i >= 66) << "a gap of 0.15 s is interpolated";
  }
  fed.Expect(69);
  ASSERT_TRUE(fed.model.IsTrusted());
  ASSERT_TRUE(fed.model.AgreementWith(fed.Pose(69), 1e-7 * Matrix6d::Identity()));
  EXPECT_LT(fed.model.AgreementWith(fed.Pose(69), 1e-7 * Matrix6d::Identity())->innovation, 30.0);
}

TEST(LateSamples, UnseenFramesWithoutThemContradictNothing) {
  Fed fed([](int64_t t_ns) { return t_ns > 2'950'000'000 && t_ns < 3'200'000'000 ? kNever : 0; });
  fed.Run(1, 59);
  const double before = fed.model.normalised_innovation();
  for (int i = 60; i < 65; ++i) {
    fed.Expect(i);
    fed.model.Miss();
    EXPECT_FALSE(fed.model.AgreementWith(fed.Pose(i), 1e-7 * Matrix6d::Identity())) << "nothing is known of the pose";
    EXPECT_FALSE(fed.Predicts());
  }
  for (int i = 65; i < 75; ++i) {
    fed.Expect(i);
    fed.Observe(i);
    EXPECT_LT(fed.model.normalised_innovation(), before + 0.5) << i;
  }
  EXPECT_TRUE(fed.model.IsTrusted());
}

TEST(LateSamples, FramesAtTheSameTimeChangeNothing) {
  Fed fed;
  fed.Run(1, 60);
  const bool trusted = fed.model.IsTrusted();
  const Eigen::Vector3d velocity_m_s = fed.model.filter().state().velocity_m_s;
  fed.model.Expect({}, fed.t_ns(60), fed.t_ns(60));
  fed.Observe(60);
  fed.model.Drift(1e-4 * Matrix6d::Identity());
  EXPECT_TRUE(trusted && fed.model.IsTrusted());
  fed.model.Expect({}, fed.t_ns(60), fed.t_ns(59));
  fed.model.Miss();
  EXPECT_TRUE(fed.model.IsTrusted());
  EXPECT_EQ(fed.model.filter().state().velocity_m_s, velocity_m_s);
  fed.Expect(61);
  EXPECT_TRUE(fed.Predicts());
}

TEST(LateSamples, JumpIsNoFaultOfTheSensor) {
  Fed fed;
  fed.Run(1, 60);
  const double before = fed.model.normalised_innovation();
  fed.Expect(61);
  fed.Observe(SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1.0, 0.0, 0.0)) * fed.Pose(61), true);
  EXPECT_EQ(fed.model.normalised_innovation(), before);
}

TEST(LateSamples, ContradictionEndsAfterSeconds) {
  Fed fed(nullptr, 400);
  fed.Run(1, 60);
  int n_changes = 0;
  int first_trusted = 0;
  for (int i = 61; i < fed.size(); ++i) {
    const bool before = fed.model.IsTrusted();
    fed.Expect(i);
    // Twenty poses that are off.
    const double off_m = i < 91 && i % 3 != 0 ? 0.05 : 0.0;
    fed.Observe(SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(off_m, 0.0, 0.0)) * fed.Pose(i));
    n_changes += fed.model.IsTrusted() != before ? 1 : 0;
    if (fed.model.IsTrusted() && first_trusted == 0 && i > 95) first_trusted = i;
  }
  EXPECT_EQ(n_changes, 2);
  EXPECT_GT(first_trusted, 90 + 100) << "five seconds";
  EXPECT_TRUE(fed.model.IsTrusted());
}

}  // namespace
}  // namespace plslam::vo
