// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include <opencv2/imgproc.hpp>

#include "dense_process/depth.h"

namespace plslam::dense {
namespace {

constexpr StereoCamera kCamera{
    .f_px = 400.0, .cx_px = 240.0, .cy_px = 120.0, .baseline_m = 0.1, .width_px = 480, .height_px = 240};
constexpr int kDisparity_px = 20;  // of the background: 2 m

/// A textured background with a blank patch, in which there may be an object with a textured border.
class BlankPatch : public testing::Test {
 protected:
  BlankPatch() {
    std::mt19937 random(7);
    background_ = cv::Mat(240, 560, CV_8U);
    for (auto at = background_.begin<uint8_t>(); at != background_.end<uint8_t>(); ++at) {
      *at = static_cast<uint8_t>(random() % 200 + 20);
    }
    cv::GaussianBlur(background_, background_, {}, 1.2);
  }

  void PaintBlank(const cv::Rect& at) { background_(at).setTo(128); }
  /// Pastes an image at `at` of the left image, nearer than the background.
  void Paste(const cv::Mat& object, const cv::Point& at, int disparity_px) {
    object_ = object;
    at_ = at;
    object_px_ = disparity_px;
  }
  DepthImage Match(const cv::Mat& in_use = {}) const {
    const cv::Rect view(0, 0, 480, 240);
    cv::Mat left = background_(view).clone();
    cv::Mat right = background_(view + cv::Point(kDisparity_px, 0)).clone();
    if (!object_.empty()) {
      object_.copyTo(left(cv::Rect(at_, object_.size())));
      object_.copyTo(right(cv::Rect(at_ - cv::Point(object_px_, 0), object_.size())));
    }
    StereoFeatures features;
    StereoPoint nearest;
    nearest.disparity_px = 60.0;
    features.points.push_back(nearest);
    return MatchPair(left, right, in_use, kCamera, features);
  }

  cv::Mat background_, object_;
  cv::Point at_;
  int object_px_ = 0;
};

TEST_F(BlankPatch, HasTheDepthAroundAsItsBound) {
  PaintBlank({200, 80, 60, 60});
  const DepthImage depth = Match();
  EXPECT_EQ(depth.z_m.at<float>(110, 230), 0.0F) << "no depth";
  EXPECT_GT(depth.at_least_m.at<float>(110, 230), 1.7F);
  EXPECT_LE(depth.at_least_m.at<float>(110, 230), 2.0F);
  EXPECT_EQ(depth.at_least_m.at<float>(30, 230), 0.0F) << "a pixel with depth needs no bound";
}

TEST_F(BlankPatch, AtTheBorderOfTheImageHasNone) {
  PaintBlank({200, 0, 60, 60});
  EXPECT_EQ(Match().at_least_m.at<float>(30, 230), 0.0F);
}

TEST_F(BlankPatch, ThatIsTooLargeHasNone) {
  PaintBlank({100, 60, 240, 120});
  EXPECT_EQ(Match().at_least_m.at<float>(120, 220), 0.0F);
}

TEST_F(BlankPatch, WithAMaskedPartHasNone) {
  PaintBlank({200, 80, 60, 60});
  cv::Mat in_use(240, 480, CV_8U, cv::Scalar(255));
  in_use(cv::Rect(245, 60, 40, 100)).setTo(0);
  const DepthImage depth = Match(in_use);
  EXPECT_EQ(depth.at_least_m.at<float>(110, 220), 0.0F) << "a body may hide what is there";
  EXPECT_EQ(depth.at_least_m.at<float>(110, 255), 0.0F);
}

TEST_F(BlankPatch, OfANearObjectIsBoundByItsEdges) {
  cv::Mat box = background_(cv::Rect(40, 100, 90, 90)).clone();
  box(cv::Rect(25, 25, 40, 40)).setTo(128);
  PaintBlank({180, 60, 90, 90});
  Paste(box, {180, 60}, 50);
  const float bound = Match().at_least_m.at<float>(105, 225);
  EXPECT_GT(bound, 0.6F);
  EXPECT_LE(bound, 0.8F) << "the object is at 0.8 m";
}

}  // namespace
}  // namespace plslam::dense
