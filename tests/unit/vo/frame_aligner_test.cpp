// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/frame_aligner.h"

#include <gtest/gtest.h>

#include <optional>
#include <utility>
#include <vector>

#include "tests/support/feature_world.h"

namespace plslam::vo {
namespace {

using test::FeatureWorld;

// Number of tracked features in the previous frame, more than any search finds here.
constexpr int kBefore = 200;
constexpr double kExpected_m = 0.1;
constexpr double kElsewhere_m = 1.6;

SE3 Sideways(double x_m) { return {Eigen::Quaterniond::Identity(), {x_m, 0.0, 0.0}}; }

/// Landmarks as seen from the origin, and a frame in which some of them look as from one pose and others as from
/// another: structure that repeats, and fits a period away.
class SeenFromTwoPlaces {
 public:
  SeenFromTwoPlaces(int n_expected, int n_elsewhere) : world_({600, 0}, 11), landmarks_(FeatureWorld::Camera(), {}) {
    TrackedFrame first(world_.Observe(SE3(), 0.0, 1));
    landmarks_.Create(SE3(), first);
    StereoFeatures seen;
    Take(Sideways(kExpected_m), 0, n_expected, seen);
    Take(Sideways(kElsewhere_m), 1, n_elsewhere, seen);
    frame_.emplace(std::move(seen));
  }

  /// Returns the aligned sideways position of the frame in metres.
  double Align_m(bool is_reliable) const {
    MotionPrediction prediction;
    prediction.T_prev_c = Sideways(kExpected_m);
    Vector6d sigmas;
    sigmas << 0.05, 0.05, 0.05, 0.1, 0.1, 0.1;
    prediction.covariance = sigmas.cwiseAbs2().asDiagonal();
    prediction.is_reliable = is_reliable;
    const FrameAligner aligner(FeatureWorld::Camera(), {});
    const auto found = aligner.Align(landmarks_, *frame_, SE3(), prediction, kBefore);
    return found ? found->T_odom_c.translation().x() : -1.0;
  }

 private:
  // Every second landmark of both, so that none is in both.
  void Take(const SE3& T_w_c, size_t parity, int count, StereoFeatures& seen) const {
    const FeatureWorld half(Half(parity), {}, 100.0);
    const StereoFeatures all = half.Observe(T_w_c, 0.0, 1);
    ASSERT_GE(all.points.size(), static_cast<size_t>(count));
    seen.points.insert(seen.points.end(), all.points.begin(), all.points.begin() + count);
  }

  std::vector<FeatureWorld::Point> Half(size_t parity) const {
    std::vector<FeatureWorld::Point> half;
    for (size_t i = parity; i < world_.points().size(); i += 2) half.push_back(world_.points()[i]);
    return half;
  }

  FeatureWorld world_;
  LocalLandmarks landmarks_;
  std::optional<TrackedFrame> frame_;
};

TEST(FrameAligner, RepeatedStructureKeepsTheMotion) {
  EXPECT_NEAR(SeenFromTwoPlaces(30, 38).Align_m(true), kExpected_m, 0.01);
}

TEST(FrameAligner, ManyMoreInliersElsewhereAreAccepted) {
  EXPECT_NEAR(SeenFromTwoPlaces(30, 60).Align_m(true), kElsewhere_m, 0.01);
}

TEST(FrameAligner, MostInliersWinAfterALoss) {
  EXPECT_NEAR(SeenFromTwoPlaces(30, 38).Align_m(false), kElsewhere_m, 0.01);
  EXPECT_NEAR(SeenFromTwoPlaces(38, 30).Align_m(false), kExpected_m, 0.01);
}

}  // namespace
}  // namespace plslam::vo
