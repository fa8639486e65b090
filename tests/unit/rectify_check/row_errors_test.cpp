// SPDX-License-Identifier: BSD-3-Clause
#include "tools/rectify_check/row_errors.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>
#include <random>

#include <opencv2/imgproc.hpp>

#include "core/features/feature_extractor.h"
#include "tools/rectify_check/rectify_picture.h"

namespace plslam::rectify_check {
namespace {

using testing::HasSubstr;

constexpr double kDeg = std::numbers::pi / 180.0;

StereoCamera Camera() { return {400.0, 320.0, 240.0, 0.1, 640, 480}; }

/// Returns points all over the image whose right counterparts are lower by `offset_px`, rotated and scaled about the
/// principal point, and have noise; some are matched by chance.
std::vector<RowMatch> Matches(int n, double offset_px, double roll_deg, double scale_percent, double outliers = 0.0) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(0.0, 640.0), v(0.0, 480.0), disparity(2.0, 60.0), share(0.0, 1.0),
      anywhere(-48.0, 48.0);
  std::normal_distribution<double> noise(0.0, 0.2);
  std::vector<RowMatch> matches;
  for (int i = 0; i < n; ++i) {
    const double y = v(random);
    const Eigen::Vector2d left(u(random), y);
    const double error = offset_px + roll_deg * kDeg * (left.x() - 320.0) + 0.01 * scale_percent * (left.y() - 240.0);
    const double row = left.y() + (share(random) < outliers ? anywhere(random) : error + noise(random));
    matches.push_back({left, {left.x() - disparity(random), row}});
  }
  return matches;
}

TEST(RowErrors, GoodRectification) {
  const RowErrors e = MeasureRows(Matches(500, 0.0, 0.0, 0.0, 0.1), Camera());
  EXPECT_LT(e.median_abs_px, 0.25);
  EXPECT_TRUE(CheckRows(e).usable) << CheckRows(e).sentence;
  EXPECT_THAT(CheckRows(e).sentence, HasSubstr("px, which is good"));
}

TEST(RowErrors, OffsetRollAndScaleAreSeparated) {
  const RowErrors e = MeasureRows(Matches(500, -1.5, 0.4, 1.2, 0.2), Camera());
  EXPECT_NEAR(e.offset_px, -1.5, 0.05);
  EXPECT_NEAR(e.roll_deg, 0.4, 0.02);
  EXPECT_NEAR(e.scale_percent, 1.2, 0.04);
  const auto sentence = [](double offset_px, double roll_deg, double scale_percent) {
    return CheckRows(MeasureRows(Matches(500, offset_px, roll_deg, scale_percent), Camera())).sentence;
  };
  EXPECT_THAT(sentence(4.0, 0.1, 0.1), HasSubstr("+4.0 px lower"));
  EXPECT_THAT(sentence(0.2, -1.5, 0.2), HasSubstr("rolled by -1.50 deg"));
  EXPECT_THAT(sentence(0.2, 0.1, 3.0), HasSubstr("+3.00 % larger"));
  EXPECT_FALSE(CheckRows(MeasureRows(Matches(500, 4.0, 0.0, 0.0), Camera())).usable);
}

TEST(RowErrors, ExchangedImages) {
  std::vector<RowMatch> matches = Matches(200, 0.0, 0.0, 0.0);
  for (RowMatch& match : matches) std::swap(match.left_px, match.right_px);
  const RowVerdict verdict = CheckRows(MeasureRows(matches, Camera()));
  EXPECT_FALSE(verdict.usable);
  EXPECT_THAT(verdict.sentence, HasSubstr("left and right are exchanged"));
}

TEST(RowErrors, NothingOrHardlyAnythingMatched) {
  for (const int n : {0, 1, 2, 3, 20}) {
    const RowErrors e = MeasureRows(Matches(n, 0.0, 0.0, 0.0), Camera());
    EXPECT_EQ(e.matches, n);
    EXPECT_TRUE(std::isfinite(e.offset_px) && std::isfinite(e.roll_deg) && std::isfinite(e.scale_percent)) << n;
    EXPECT_FALSE(CheckRows(e).usable) << n;
  }
}

cv::Mat Blobs() {
  cv::Mat image(240, 320, CV_8UC1, cv::Scalar(90));
  std::mt19937 random(5);
  std::uniform_int_distribution<int> x(0, 319), y(0, 239), size(4, 18), grey(0, 255);
  for (int i = 0; i < 150; ++i) {
    cv::rectangle(image, {x(random), y(random), size(random), size(random)}, cv::Scalar(grey(random)), cv::FILLED);
  }
  return image;
}

TEST(RowErrors, ImagesThatAreShiftedByThreeRows) {
  const cv::Mat left = Blobs();
  cv::Mat right;
  const cv::Mat shift = (cv::Mat_<double>(2, 3) << 1, 0, -7, 0, 1, 3);
  cv::warpAffine(left, right, shift, left.size());
  FeatureOptions options;
  options.features = FeatureTypes::kPoints;
  FeatureExtractor extractor(options);
  const auto matches = MatchAcrossRows(extractor.Extract(left), extractor.Extract(right), left.rows);
  const RowErrors e = MeasureRows(matches, {200.0, 160.0, 120.0, 0.1, 320, 240});
  EXPECT_GT(e.matches, 100);
  EXPECT_NEAR(e.median_px, 3.0, 0.1);
}

TEST(RectifyPicture, ShowsBothImagesLinesAndPoints) {
  const cv::Mat left = Blobs();
  const cv::Mat picture =
      DrawRectification({left, {}}, {left, {}}, {{{100, 100}, {90, 100}}, {{50, 60}, {40, 63}}}, "caption");
  EXPECT_GT(picture.cols, 2 * left.cols);
  EXPECT_GT(picture.rows, left.rows);
  const auto circle = picture.at<cv::Vec3b>(100, 103);
  EXPECT_GT(circle[1], circle[0] + 80) << "the green circle of a good match";
  EXPECT_EQ(DrawRectification({left, {}}, {left, {}}, {}, "").cols, picture.cols);
}

TEST(RectifyPicture, ShadesMaskedPixels) {
  const cv::Mat image = Blobs();
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  mask.rowRange(200, 240).setTo(0);
  const cv::Mat plain = DrawRectification({image, {}}, {image, {}}, {}, "");
  const cv::Mat shaded = DrawRectification({image, {}}, {image, mask}, {}, "");
  EXPECT_EQ(cv::norm(plain.colRange(0, 320), shaded.colRange(0, 320)), 0.0);
  EXPECT_EQ(cv::norm(plain.rowRange(0, 200), shaded.rowRange(0, 200)), 0.0);
  EXPECT_NE(plain.at<cv::Vec3b>(225, 400), shaded.at<cv::Vec3b>(225, 400));
}

}  // namespace
}  // namespace plslam::rectify_check
