// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/depth_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <vector>

#include "core/datasets/open_dataset.h"
#include "core/datasets/recordings/topic_names.h"
#include "core/io/images/png_codec.h"
#include "tests/unit/datasets/bag_file.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam {
namespace {

using test::ErrorOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

constexpr int kWidth = 6, kHeight = 2;
const cv::Size kSize(kWidth, kHeight);

template <class Value>
std::vector<uint8_t> BytesOf(const std::vector<Value>& row) {
  std::vector<uint8_t> bytes(kHeight * row.size() * sizeof(Value));
  for (int y = 0; y < kHeight; ++y) {
    std::memcpy(bytes.data() + y * row.size() * sizeof(Value), row.data(), row.size() * sizeof(Value));
  }
  return bytes;
}

std::vector<int> FirstRow(const cv::Mat& depths) {
  return {depths.ptr<uint16_t>(0), depths.ptr<uint16_t>(0) + depths.cols};
}

cv::Mat Depths(const std::string& encoding, const std::vector<uint8_t>& bytes, double units_per_m = 1000.0,
               bool is_big_endian = false) {
  return DepthsOfRosPixels({kWidth, kHeight, 0, encoding, is_big_endian, bytes}, kSize, units_per_m);
}

TEST(DepthImages, WideOnesStayAndMetresAreConverted) {
  const std::vector<uint8_t> wide = BytesOf<uint16_t>({0, 1, 500, 2000, 40'000, 65'535});
  EXPECT_THAT(FirstRow(Depths("16UC1", wide)), ElementsAre(0, 1, 500, 2000, 40'000, 65'535));
  EXPECT_THAT(FirstRow(Depths("mono16", wide, 5000.0, true)), ElementsAre(0, 256, 62'465, 53'255, 16'540, 65'535));
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<uint8_t> metres = BytesOf<float>({kNan, kInfinity, -1.0F, 0.0F, 1.2344F, 65.6F});
  EXPECT_THAT(FirstRow(Depths("32FC1", metres)), ElementsAre(0, 0, 0, 0, 1234, 0));
  EXPECT_THAT(FirstRow(Depths("32FC1", metres, 5000.0)), ElementsAre(0, 0, 0, 0, 6172, 0));
}

TEST(DepthImages, OtherPixelsAreRejected) {
  EXPECT_THAT(ErrorOf([] { Depths("mono8", std::vector<uint8_t>(12)); }), HasSubstr("'mono8', not as depths"));
  EXPECT_THAT(ErrorOf([] { Depths("32FC1", std::vector<uint8_t>(47)); }), HasSubstr("has 47 bytes in rows of 24"));
  EXPECT_THAT(ErrorOf([] {
                DepthsOfRosPixels({kWidth, 3, 0, "16UC1", false, {}}, kSize, 1000.0);
              }),
              HasSubstr("has 6 x 3 pixels instead of 6 x 2: depth maps must be registered to the colour image"));
}

/// As compressed_depth_image_transport writes it: an unused number, a and b, and a PNG file.
std::vector<uint8_t> Compressed(const cv::Mat& pixels, float a, float b) {
  const std::string file = EncodePng(pixels);
  std::vector<uint8_t> bytes(12 + file.size());
  std::memcpy(bytes.data() + 4, &a, sizeof(a));
  std::memcpy(bytes.data() + 8, &b, sizeof(b));
  std::memcpy(bytes.data() + 12, file.data(), file.size());
  return bytes;
}

TEST(DepthImages, CompressedOnes) {
  const cv::Mat pixels(kSize, CV_16UC1, cv::Scalar(1500));
  const auto depth = [&](const std::string& format, const std::vector<uint8_t>& bytes) {
    return FirstRow(DepthsOfCompressed(format, bytes, kSize, 1000.0)).at(0);
  };
  EXPECT_EQ(depth("16UC1; compressedDepth", Compressed(pixels, 0.0F, 0.0F)), 1500);
  EXPECT_EQ(depth("16UC1; compressedDepth png", Compressed(pixels, 0.0F, 0.0F)), 1500);
  // 3000 / (1500 + 100) m
  EXPECT_EQ(depth("32FC1; compressedDepth png", Compressed(pixels, 3000.0F, -100.0F)), 1875);
  EXPECT_EQ(depth("32FC1; compressedDepth png", Compressed(pixels, 3000.0F, 1500.0F)), 0) << "infinite";
  EXPECT_EQ(depth("32FC1; compressedDepth png", Compressed(cv::Mat::zeros(kSize, CV_16UC1), 3000.0F, -1.0F)), 0);
  const std::string file = EncodePng(pixels);
  EXPECT_EQ(depth("16UC1; png compressed ", {file.begin(), file.end()}), 1500);
}

TEST(DepthImages, DamagedCompressedOnesAreRejected) {
  const auto error = [](const std::string& format, const std::vector<uint8_t>& bytes) {
    return ErrorOf([&] { DepthsOfCompressed(format, bytes, kSize, 1000.0); });
  };
  const cv::Mat pixels(kSize, CV_16UC1, cv::Scalar(1500));
  const std::vector<uint8_t> whole = Compressed(pixels, 0.0F, 0.0F);
  EXPECT_THAT(error("16UC1; compressedDepth rvl", whole),
              HasSubstr("set the parameter format of compressedDepth to png"));
  EXPECT_THAT(error("16UC1; compressedDepth", Compressed(cv::Mat::zeros(kSize, CV_8UC1), 0.0F, 0.0F)),
              HasSubstr("not of 16-bit depths"));
  EXPECT_THAT(error("16UC1; compressedDepth", Compressed(cv::Mat::zeros(5, 5, CV_16UC1), 0.0F, 0.0F)),
              HasSubstr("has 5 x 5 pixels instead of 6 x 2"));
  for (size_t n = 0; n + 1 < whole.size(); n += 3) {
    EXPECT_NE(error("16UC1; compressedDepth", {whole.begin(), whole.begin() + static_cast<ptrdiff_t>(n)}), "") << n;
  }
}

TEST(DepthImages, TopicsOfCamerasAreFound) {
  EXPECT_THAT(RgbdTopics({"/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"}),
              ElementsAre(Pair("/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw")));
  EXPECT_THAT(RgbdTopics({"/camera/rgb/image_color", "/camera/depth/image"}),
              ElementsAre(Pair("/camera/rgb/image_color", "/camera/depth/image")));
  EXPECT_THAT(
      RgbdTopics({"/zed/rgb/image_rect_color", "/zed/rgb/image_rect_color/compressed", "/zed/depth/depth_registered",
                  "/zed/depth/depth_registered/compressedDepth"}),
      ElementsAre(Pair("/zed/rgb/image_rect_color", "/zed/depth/depth_registered"),
                  Pair("/zed/rgb/image_rect_color/compressed", "/zed/depth/depth_registered/compressedDepth")));
  EXPECT_TRUE(RgbdTopics({"/other/color/image_raw", "/camera/depth/image"}).empty());
  EXPECT_TRUE(StereoTopics({"/left/depth/image", "/right/depth/image"}).empty());
}

TEST(DepthImages, NameOfTheCameraHasNoMeaning) {
  EXPECT_FALSE(NamesDepth("/depthai/left/image_raw", "/depthai/right/image_raw"));
  EXPECT_FALSE(NamesDepth("/depthai_left/image", "/depthai_right/image"));
  EXPECT_FALSE(NamesDepth("/pairs", ""));
  EXPECT_TRUE(NamesDepth("/camera/default/image", "/camera/depth/image"));
  EXPECT_TRUE(NamesDepth("/depth_camera/color/image_raw", "/depth_camera/depth/image_raw"));
  const std::set<std::string> images{"/depth_camera/color/image_raw", "/depth_camera/depth/image_raw",
                                     "/depth_camera/infra1/image_rect_raw", "/depth_camera/infra2/image_rect_raw"};
  EXPECT_THAT(StereoTopics(images),
              ElementsAre(Pair("/depth_camera/infra1/image_rect_raw", "/depth_camera/infra2/image_rect_raw")));
  EXPECT_THAT(RgbdTopics(images),
              ElementsAre(Pair("/depth_camera/color/image_raw", "/depth_camera/depth/image_raw")));
}

class RgbdRecording : public test::RecordingFileTest {
 protected:
  RgbdRecording() : RecordingFileTest("a.mcap") {}
  static test::RecordingOptions Options(const std::string& encoding) {
    return {.left = "/camera/color/image_raw",
            .right = "/camera/aligned_depth_to_color/image_raw",
            .right_encoding = encoding,
            .distortion = {}};
  }
  /// `factor` and `offset` of the true values.
  void ExpectDepths(int factor, int offset) const {
    const auto dataset = OpenDataset(path(), "");
    const RigCalibration& rig = dataset->rig();
    EXPECT_EQ(rig.kind, RigCalibration::Kind::kRgbd);
    EXPECT_EQ(rig.depth_units_per_m, 1000.0);
    EXPECT_EQ(rig.left.fx_px, 40.0);
    ASSERT_EQ(dataset->size(), 3);
    const StereoImages images = dataset->Read(1);
    EXPECT_EQ(images.left.at<uint8_t>(5, 7), test::TinyPixel(1, 0, 7, 5));
    ASSERT_EQ(images.right.type(), CV_16UC1);
    EXPECT_EQ(images.right.at<uint16_t>(5, 7), factor * test::TinyPixel(1, 1, 7, 5) + offset);
  }
};

TEST_F(RgbdRecording, ColourAndDepthArePlayed) {
  test::MakeMcapFile(path(), Options("16UC1"));
  ExpectDepths(4, 2);
  test::MakeMcapFile(path(), Options("32FC1"));
  ExpectDepths(10, 0);
  test::MakeMcapFile(path(), Options("rgb8"));
  EXPECT_THAT(ErrorOf([&] { OpenDataset(path(), ""); }), HasSubstr("encoded as 'rgb8', not as depths"));
}

TEST_F(RgbdRecording, CameraFilesOfStereoRigsAreRefused) {
  test::MakeMcapFile(path(), Options("16UC1"));
  const std::string camera = path() + ".yaml";
  test::WriteText(camera, "baseline_m: 0.1\nleft:\n  focal_length_px: [40, 40]\n  principal_point_px: [24, 16]\n");
  EXPECT_THAT(
      ErrorOf([&] { OpenDataset(path() + "?camera=" + camera, ""); }),
      HasSubstr("is for a stereo camera, but /camera/aligned_depth_to_color/image_raw has depths by its name"));
  test::WriteText(
      camera,
      "kind: rgbd\ndepth_units_per_m: 500\nleft:\n  focal_length_px: [41, 41]\n  principal_point_px: [24, "
      "16]\n");
  EXPECT_EQ(OpenDataset(path() + "?camera=" + camera, "")->rig().depth_units_per_m, 500.0);
}

}  // namespace
}  // namespace plslam
