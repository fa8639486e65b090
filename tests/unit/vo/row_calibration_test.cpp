#include "vo_process/row_calibration.h"

#include <gtest/gtest.h>

#include <memory>
#include <opencv2/imgproc.hpp>
#include <random>

#include "core/geometry/se3.h"
#include "player/open_dataset.h"
#include "tests/support/odometry_run.h"

namespace plslam {
namespace {

const StereoCamera kRowRig{
    .f_px = 400.0, .cx_px = 320.0, .cy_px = 240.0, .baseline_m = 0.1, .width_px = 640, .height_px = 480};

RowField::Coefficients SomeRows() {
  RowField::Coefficients rows;
  rows << -0.3, 0.2, 0.1, -0.3, 1.2, 0.1;
  return rows;
}

/// Matches all over the image whose rows are those of `rows`, up to noise; every eighth is wrong.
StereoFeatures MatchesWithRows(const RowField& rows, double sigma_px, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  StereoFeatures features;
  for (int i = 0; i < 200; ++i) {
    StereoPoint point;
    point.left.px = {639.0 * uniform(random), 479.0 * uniform(random)};
    point.disparity_px = 1.0 + 60.0 * uniform(random);
    point.sigma_row_px = sigma_px;
    point.row_offset_px =
        rows.Offset_px(point.left.px - Eigen::Vector2d(point.disparity_px, 0.0)) + sigma_px * normal(random);
    if (i % 8 == 0) point.row_offset_px += 6.0 * uniform(random) - 3.0;
    features.points.push_back(point);
  }
  return features;
}

RowField Learned(const RowField& truth, int n_frames, const RowCalibrationOptions& options = {}) {
  RowCalibration calibration(kRowRig, options);
  std::mt19937 random(5);
  for (int i = 0; i < n_frames; ++i) calibration.Observe(MatchesWithRows(truth, 0.1, random));
  return calibration.field();
}

TEST(RowCalibration, FindsRowsThatDifferInSpiteOfWrongMatches) {
  const RowField truth(kRowRig, SomeRows());
  const RowField found = Learned(truth, 10);
  for (const Eigen::Vector2d& px :
       {Eigen::Vector2d(0.0, 0.0), {639.0, 0.0}, {0.0, 479.0}, {639.0, 479.0}, {320.0, 240.0}}) {
    EXPECT_NEAR(found.Offset_px(px), truth.Offset_px(px), 0.1);
  }
}

TEST(RowCalibration, OneFrameIsEnoughForLargeErrors) {
  EXPECT_NEAR(Learned({kRowRig, SomeRows()}, 1).Offset_px({639.0, 479.0}), 1.0, 0.25);
}

TEST(RowCalibration, GoodRigsAreLeftAlone) {
  EXPECT_TRUE(Learned(RowField(), 50).is_zero());
  EXPECT_TRUE(Learned({kRowRig, 0.2 * SomeRows()}, 50).is_zero()) << "too little to matter";
}

TEST(RowCalibration, SwitchedOffItLearnsNothing) {
  EXPECT_TRUE(Learned({kRowRig, SomeRows()}, 10, {.enabled = false}).is_zero());
}

TEST(RowCalibration, MatchesThatDoNotTellTheirRowsAreNotAsked) {
  RowCalibration calibration(kRowRig, {});
  std::mt19937 random(5);
  for (int i = 0; i < 10; ++i) {
    StereoFeatures features = MatchesWithRows({kRowRig, SomeRows()}, 0.1, random);
    for (size_t k = 0; k < features.points.size(); ++k) {
      StereoPoint& point = features.points[k];
      if (k % 3 == 0) point.disparity_px = -1.0;
      if (k % 3 == 1) point.sigma_row_px = -1.0;
      if (k % 3 == 2) point.sigma_row_px = 0.8;
    }
    calibration.Observe(features);
  }
  calibration.Observe({});
  EXPECT_TRUE(calibration.field().is_zero());
}

/// Somebody has bent the rig after it was calibrated: the right camera is turned.
class BentRig : public Dataset {
 public:
  BentRig(const Dataset& straight, const Eigen::Vector3d& turn_rad) : straight_(straight) {
    const CameraCalibration& right = straight.rig().right;
    Eigen::Matrix3d K = Eigen::Matrix3d::Identity();
    K(0, 0) = right.fx_px;
    K(1, 1) = right.fy_px;
    K(0, 2) = right.cx_px;
    K(1, 2) = right.cy_px;
    const Eigen::Matrix3d H = K * ExpSO3(turn_rad).toRotationMatrix() * K.inverse();
    homography_ = cv::Mat(3, 3, CV_64F);
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) homography_.at<double>(r, c) = H(r, c);
    }
  }
  std::string name() const override { return straight_.name(); }
  const RigCalibration& rig() const override { return straight_.rig(); }
  int size() const override { return straight_.size(); }
  int64_t t_ns(int index) const override { return straight_.t_ns(index); }
  std::optional<SE3> GroundTruth(int index) const override { return straight_.GroundTruth(index); }
  StereoImages Read(int index) const override {
    StereoImages images = straight_.Read(index);
    const cv::Mat right = images.right;
    images.right = cv::Mat();
    cv::warpPerspective(right, images.right, homography_, right.size(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    return images;
  }

 private:
  const Dataset& straight_;
  cv::Mat homography_;
};

TEST(RowCalibration, WithLittleToSeeItWaitsForSomeFramesOnly) {
  RowCalibration calibration(kRowRig, {});
  for (int i = 0; i < 20; ++i) calibration.Observe({});
  EXPECT_FALSE(calibration.has_learned()) << "in the dark";
  StereoFeatures few;
  few.points.resize(3);
  for (int i = 0; i < 10; ++i) {
    EXPECT_FALSE(calibration.has_learned());
    calibration.Observe(few);
  }
  EXPECT_TRUE(calibration.has_learned());
}

double ErrorOf(const Dataset& dataset, bool follows_rows) {
  VoOptions options;
  options.row_calibration.enabled = follows_rows;
  return test::AbsoluteTrajectoryError(test::RunOdometry(dataset, options));
}

// A roll of 10 mrad and a pitch of 5: rows differ by up to 3 pixels here. Or a pitch of 15, 4 pixels.
TEST(RowCalibration, BentRigsAreFollowed) {
  const auto straight = OpenDataset("synthetic:room?size=376x240&rate=10&frames=60", "");
  const double straight_m = ErrorOf(*straight, true);
  EXPECT_EQ(ErrorOf(*straight, false), straight_m) << "a good rig is left alone";
  for (const Eigen::Vector3d& turn_rad : {Eigen::Vector3d(-0.005, 0.0, 0.01), Eigen::Vector3d(0.015, 0.0, 0.0)}) {
    const BentRig bent(*straight, turn_rad);
    const double followed_m = ErrorOf(bent, true);
    EXPECT_LT(followed_m, 1.6 * straight_m) << turn_rad.transpose();
    EXPECT_GT(ErrorOf(bent, false), 5.0 * followed_m) << turn_rad.transpose();
  }
}

}  // namespace
}  // namespace plslam
