// SPDX-License-Identifier: BSD-3-Clause
#include "core/geometry/image_mask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "core/geometry/rectifier.h"
#include "tests/unit/geometry/test_rigs.h"

namespace plslam {
namespace {

using testing::HasSubstr;

CameraCalibration Masked(const cv::Mat& image) {
  CameraCalibration camera;
  camera.width_px = image.cols;
  camera.height_px = image.rows;
  camera.mask = TraceMask(image);
  return camera;
}

/// Pixels that differ although all their neighbours are alike in `image`.
int WrongInside(const cv::Mat& image, const CameraCalibration& camera) {
  cv::Mat drawn = DrawMask(camera);
  if (drawn.empty()) drawn = cv::Mat(image.size(), CV_8UC1, cv::Scalar(255));
  cv::Mat least, most;
  cv::erode(image, least, cv::Mat::ones(3, 3, CV_8U));
  cv::dilate(image, most, cv::Mat::ones(3, 3, CV_8U));
  const cv::Mat uniform = (least != 0) == (most != 0);
  return cv::countNonZero(((image != 0) != (drawn != 0)) & uniform);
}

cv::Mat InUse(int width, int height) { return {height, width, CV_8UC1, cv::Scalar(255)}; }

MaskPolygon Rectangle(float x0, float y0, float x1, float y1) { return {{{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}}}; }

TEST(ImageMask, EmptyMaskHasNoPolygonAndNoImage) {
  EXPECT_TRUE(TraceMask(InUse(30, 20)).empty());
  EXPECT_TRUE(DrawMask(Masked(InUse(30, 20))).empty());
}

TEST(ImageMask, RectangleHasTheSamePixelsThereAndBack) {
  cv::Mat image = InUse(60, 40);
  image(cv::Rect(0, 30, 60, 10)).setTo(0);
  const CameraCalibration camera = Masked(image);
  ASSERT_EQ(camera.mask.size(), 1U);
  EXPECT_EQ(camera.mask[0].corners_px.size(), 4U);
  EXPECT_EQ(cv::norm(image, DrawMask(camera), cv::NORM_INF), 0.0);
}

TEST(ImageMask, HolesAndIslandsInThemStay) {
  cv::Mat image = InUse(200, 200);
  cv::circle(image, {100, 100}, 90, cv::Scalar(0), cv::FILLED);
  cv::circle(image, {100, 100}, 60, cv::Scalar(1), cv::FILLED);
  cv::circle(image, {110, 100}, 30, cv::Scalar(0), cv::FILLED);
  const CameraCalibration camera = Masked(image);
  EXPECT_EQ(camera.mask.size(), 3U);
  EXPECT_EQ(WrongInside(image, camera), 0);
  EXPECT_EQ(MaskComplaint(camera), "");
}

TEST(ImageMask, FisheyeBorderIsARing) {
  cv::Mat image(512, 512, CV_8UC1, cv::Scalar(0));
  cv::circle(image, {256, 256}, 250, cv::Scalar(255), cv::FILLED);
  const CameraCalibration camera = Masked(image);
  EXPECT_EQ(WrongInside(image, camera), 0);
  EXPECT_EQ(MaskComplaint(camera), "") << "a smooth outline takes few corners";
}

TEST(ImageMask, RandomShapesStayWithinHalfAPixel) {
  cv::RNG random(7);
  for (int i = 0; i < 20; ++i) {
    cv::Mat noise(120, 160, CV_8UC1);
    random.fill(noise, cv::RNG::UNIFORM, 0, 256);
    cv::GaussianBlur(noise, noise, {0, 0}, 1.0 + 0.4 * i);
    const cv::Mat image = noise > 127;
    EXPECT_EQ(WrongInside(image, Masked(image)), 0) << i;
  }
}

TEST(ImageMask, PolygonsAddUpEvenOutsideTheImage) {
  CameraCalibration camera = Masked(InUse(50, 40));
  camera.mask = {Rectangle(-40, 30, 90, 70), Rectangle(-10, 20, 10, 35)};
  const cv::Mat mask = DrawMask(camera);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 50; ++x) {
      const bool out = y >= 30 || (x <= 10 && y >= 20 && y <= 35);
      EXPECT_EQ(mask.at<uint8_t>(y, x), out ? 0 : 255) << x << ", " << y;
    }
  }
}

TEST(ImageMask, ErrorsNameValueAndBound) {
  CameraCalibration camera = Masked(InUse(50, 40));
  camera.mask = {Rectangle(0, 0, 101, 5)};
  EXPECT_THAT(MaskComplaint(camera), HasSubstr("corner [101, 0] is not within -50 to 100 and -40 to 80 pixels"));
  camera.mask = {Rectangle(0, 0, 49, 39)};
  EXPECT_THAT(MaskComplaint(camera), HasSubstr("no pixel is in use"));
  camera.mask.assign(501, Rectangle(0, 0, 5, 5));
  EXPECT_THAT(MaskComplaint(camera), HasSubstr("2004 corners, at most 2000"));
}

TEST(ImageMask, ShadeChangesOnlyMaskedPixels) {
  cv::Mat mask = InUse(20, 10);
  mask(cv::Rect(0, 5, 20, 5)).setTo(0);
  for (const int grey : {0, 100, 255}) {
    cv::Mat picture(10, 20, CV_8UC3, cv::Scalar::all(grey));
    ShadeMask(mask, picture);
    EXPECT_EQ(picture.at<cv::Vec3b>(4, 3), cv::Vec3b::all(static_cast<uint8_t>(grey)));
    const cv::Vec3b shaded = picture.at<cv::Vec3b>(5, 3);
    EXPECT_GT(shaded[2], shaded[1] + 30) << grey;
  }
}

/// Every rectified pixel against the pixel as recorded that it shows.
void ExpectWarped(const RigCalibration& rig) {
  const Rectifier rectifier(rig);
  const Rectification r = Rectify(rig);
  const cv::Mat recorded = DrawMask(rig.right);
  ASSERT_FALSE(rectifier.right_mask().empty());
  int n_out = 0;
  for (int v = 0; v < r.camera.height_px; v += 3) {
    for (int u = 0; u < r.camera.width_px; u += 3) {
      const auto raw = r.right.RawPixel(r.camera, {u, v});
      const cv::Point at(static_cast<int>(std::lround(raw->x())), static_cast<int>(std::lround(raw->y())));
      if (!cv::Rect(0, 0, recorded.cols, recorded.rows).contains(at)) continue;
      const bool shown = rectifier.right_mask().at<uint8_t>(v, u) != 0;
      n_out += shown ? 0 : 1;
      EXPECT_EQ(shown, recorded.at<uint8_t>(at) != 0) << u << ", " << v;
    }
  }
  EXPECT_GT(n_out, 1000);
}

TEST(ImageMask, IsWarpedAsTheImage) {
  RigCalibration rig = test::EurocRig();
  rig.right.mask = {{{{100.0F, 479.0F}, {380.0F, 200.5F}, {700.0F, 479.0F}}}};
  ExpectWarped(rig);
  EXPECT_TRUE(Rectifier(rig).left_mask().empty());
}

TEST(ImageMask, MaskOfARectifiedPairIsUnchanged) {
  RigCalibration rig = test::IdealRig();
  rig.left.mask = {Rectangle(0, 400, 639, 479)};
  const Rectifier rectifier(rig);
  ASSERT_TRUE(rectifier.IsIdentity());
  EXPECT_EQ(cv::countNonZero(rectifier.left_mask()), 640 * 400);
  EXPECT_TRUE(rectifier.right_mask().empty());
}

}  // namespace
}  // namespace plslam
