// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/simulator.h"

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/distortion.h"

namespace plslam {
namespace {

uint64_t Fnv(const cv::Mat& image, uint64_t hash) {
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      hash = (hash ^ image.at<uint8_t>(y, x)) * 0x100000001b3ULL;
    }
  }
  return hash;
}

uint64_t HashOfPair(const StereoImages& pair) { return Fnv(pair.right, Fnv(pair.left, 0xcbf29ce484222325ULL)); }

// A deliberate change of a world must update these values; any other change is a fault: of the compiler's floating
// point, or of a function of the C library that slipped in.
TEST(Synthetic, FramesAreBitIdenticalEverywhere) {
  const std::map<std::string, uint64_t> expected = {
      {"room", 0x6b7c035725cd96f9ULL},
      {"corridor", 0x7196b63c04597a90ULL},
      {"street", 0xea17d59726927ebeULL},
      {"whitewall", 0xf45cb7666b4bf777ULL},
      {"room?distorted=1&blur=0.5&size=320x240&seed=7", 0x63bf502847347e4ULL},
      {"street?bodies=2&static_body=0.2&size=320x240", 0xf45e772b491980ffULL},
      {"room?standing=1&body=crowd&size=320x240", 0xd484fbca837fc08eULL},
  };
  for (const auto& [description, hash] : expected) {
    const uint64_t found = HashOfPair(OpenSyntheticDataset(description)->Read(7));
    EXPECT_EQ(found, hash) << description << std::hex << ": found 0x" << found << "ULL";
  }
}

TEST(Synthetic, ReadingIsRandomAccess) {
  const auto a = OpenSyntheticDataset("room?size=160x120");
  const auto b = OpenSyntheticDataset("room?size=160x120");
  a->Read(3);
  EXPECT_EQ(HashOfPair(a->Read(20)), HashOfPair(b->Read(20)));
  EXPECT_NE(HashOfPair(a->Read(20)), HashOfPair(a->Read(21)));
  EXPECT_EQ(a->Read(20).frame_id, 20);
}

// The next frame's left image is the view of a right camera one frame late at the position of the left one.
TEST(Synthetic, LateRightImageIsTakenFromTheLaterPose) {
  const std::string world = "room?size=160x120&noise=0&exposure=0&rate=20";
  const auto on_time = OpenSyntheticDataset(world);
  const auto late = OpenSyntheticDataset(world + "&right_late_ms=50");
  EXPECT_EQ(Fnv(late->Read(3).left, 1), Fnv(on_time->Read(3).left, 1));
  EXPECT_EQ(Fnv(late->Read(3).right, 1), Fnv(on_time->Read(4).right, 1));
}

TEST(Synthetic, RollingShutterTakesRowsOneAfterTheOther) {
  const std::string world = "room?size=160x120&noise=0&exposure=0&rate=20";
  const auto at_once = OpenSyntheticDataset(world);
  const auto rolling = OpenSyntheticDataset(world + "&readout_ms=50");
  const cv::Mat image = rolling->Read(3).left;
  const auto difference = [&](int frame, int row) {
    return cv::norm(image.row(row), at_once->Read(frame).left.row(row), cv::NORM_L1) / image.cols;
  };
  EXPECT_LT(difference(3, 1), 0.5);
  EXPECT_GT(difference(4, 1), 2.0);
  EXPECT_LT(difference(4, 118), 0.5);
  EXPECT_GT(difference(3, 118), 2.0);
}

TEST(Synthetic, StreaksChangeInEveryImageAndDirtStays) {
  const std::string world = "whitewall?size=160x120&noise=0&exposure=0";
  const auto clean = OpenSyntheticDataset(world);
  const auto changed = [&](const std::string& option, int frame, bool right) {
    const auto dataset = OpenSyntheticDataset(world + option);
    const StereoImages a = clean->Read(frame);
    const StereoImages b = dataset->Read(frame);
    cv::Mat difference;
    cv::absdiff(right ? a.right : a.left, right ? b.right : b.left, difference);
    return cv::Mat(difference > 10);
  };
  const auto common = [](const cv::Mat& a, const cv::Mat& b) {
    return static_cast<double>(cv::countNonZero(a & b)) /
           std::max(1, std::min(cv::countNonZero(a), cv::countNonZero(b)));
  };
  for (const bool right : {false, true}) {
    EXPECT_LT(common(changed("&streaks=10", 3, right), changed("&streaks=10", 4, right)), 0.4);
    EXPECT_GT(common(changed("&dirt=5", 3, right), changed("&dirt=5", 4, right)), 0.9);
  }
  EXPECT_LT(common(changed("&streaks=10", 3, false), changed("&streaks=10", 3, true)), 0.4);
  EXPECT_LT(common(changed("&dirt=5", 3, false), changed("&dirt=5", 3, true)), 0.6);
}

TEST(Synthetic, ChangedRoomKeepsMostOfItself) {
  const std::string world = "room?size=160x120&noise=0&exposure=0&loops=2";
  const auto same = OpenSyntheticDataset(world);
  const auto changed = OpenSyntheticDataset(world + "&changed_after=1");
  EXPECT_EQ(HashOfPair(changed->Read(299)), HashOfPair(same->Read(299)));
  double different = 0.0;
  constexpr int kStep = 30;
  for (int frame = 300; frame < 600; frame += kStep) {
    cv::Mat difference;
    cv::absdiff(changed->Read(frame).left, same->Read(frame).left, difference);
    different += static_cast<double>(cv::countNonZero(difference > 10)) / static_cast<double>(difference.total());
  }
  different /= 300 / kStep;
  EXPECT_GT(different, 0.02);
  EXPECT_LT(different, 0.4);
}

TEST(Synthetic, SeedsDiffer) {
  EXPECT_NE(HashOfPair(OpenSyntheticDataset("room?size=160x120&noise=0&seed=1")->Read(0)),
            HashOfPair(OpenSyntheticDataset("room?size=160x120&noise=0&seed=2")->Read(0)));
}

TEST(Synthetic, LoopsCloseToTheLastBit) {
  for (const std::string world : {"room", "corridor", "street", "whitewall"}) {
    const auto dataset = OpenSyntheticDataset(world + "?size=64x48&loops=2");
    const SE3 first = *dataset->GroundTruth(0);
    const SE3 last = *dataset->GroundTruth(dataset->size() - 1);
    EXPECT_EQ(first.matrix(), last.matrix()) << world;
    EXPECT_GT((first.translation() - dataset->GroundTruth(dataset->size() / 4)->translation()).norm(), 1.0) << world;
  }
}

TEST(Synthetic, TimesAreRegularAndIncrease) {
  const auto dataset = OpenSyntheticDataset("room?size=64x48&frames=30&rate=40");
  ASSERT_EQ(dataset->size(), 30);
  EXPECT_EQ(dataset->t_ns(0), 0);
  EXPECT_EQ(dataset->t_ns(1), 25000000);
  EXPECT_EQ(dataset->t_ns(29), 725000000);
}

TEST(Synthetic, RigMatchesTheRenderedImages) {
  const auto plain = OpenSyntheticDataset("room?baseline=0.2&fov=90&size=640x480");
  EXPECT_NEAR(plain->rig().left.fx_px, 320.0, 1e-9);
  EXPECT_EQ(plain->rig().left.cx_px, 319.5);
  EXPECT_EQ(plain->rig().left.model, "pinhole");
  EXPECT_EQ(plain->rig().right.T_b_cam.translation().x(), 0.2);
  const auto distorted = OpenSyntheticDataset("room?distorted=1&size=64x48");
  EXPECT_EQ(distorted->rig().left.model, "radtan");
  EXPECT_EQ(distorted->rig().left.distortion.size(), 4u);
  EXPECT_GT(distorted->rig().right.T_b_cam.Log().tail<3>().norm(), 0.01);
  const cv::Mat image = distorted->Read(0).left;
  EXPECT_EQ(image.cols, 64);
  EXPECT_EQ(image.rows, 48);
}

// The middles of the thirds are columns 7.5, 23.5 and 39.5; everything lies in a plane 2 m away, at a disparity of 4
// px.
TEST(Synthetic, DisparityBiasMovesTheRightImage) {
  constexpr int kWidth = 48;
  const synthetic::DisparityBias parabola({0.25, -0.5, 1.0}, kWidth);
  EXPECT_DOUBLE_EQ(parabola.At(7.5), 0.25);
  EXPECT_DOUBLE_EQ(parabola.At(23.5), -0.5);
  EXPECT_DOUBLE_EQ(parabola.At(39.5), 1.0);
  std::vector<float> image(kWidth);
  for (int x = 0; x < kWidth; ++x) image[x] = static_cast<float>(10 * x);
  const std::vector<float> depth_m(kWidth, 2.0F);
  const synthetic::DisparityBias constant({2.0, 2.0, 2.0}, kWidth);
  const std::vector<float> shifted = constant.Apply(image, depth_m, 8.0);
  for (int x = 1; x < kWidth - 5; ++x) EXPECT_EQ(shifted[x], image[x + 2]) << x;
  const std::vector<float> bent = parabola.Apply(image, depth_m, 8.0);
  for (int x = 2; x < kWidth - 8; ++x) EXPECT_NEAR(bent[x], 10.0 * (x + parabola.At(x + 4.0)), 1e-3) << x;
}

TEST(Synthetic, DisparityBiasLeavesTheLeftImageAndTheTruth) {
  const auto plain = OpenSyntheticDataset("street?size=160x120&frames=3");
  const auto none = OpenSyntheticDataset("street?size=160x120&frames=3&disparity_bias=0,0,0");
  const auto biased = OpenSyntheticDataset("street?size=160x120&frames=3&disparity_bias=0,0,-2");
  const auto differ = [](const cv::Mat& a, const cv::Mat& b) { return cv::norm(a, b, cv::NORM_INF) > 0.0; };
  EXPECT_FALSE(differ(plain->Read(2).right, none->Read(2).right));
  EXPECT_FALSE(differ(plain->Read(2).left, biased->Read(2).left));
  EXPECT_TRUE(differ(plain->Read(2).right, biased->Read(2).right));
  EXPECT_EQ(plain->rig().left.cx_px, biased->rig().left.cx_px);
  EXPECT_THROW(OpenSyntheticDataset("street?distorted=1&disparity_bias=0,0,-2"), DatasetError);
}

TEST(Synthetic, NoiseHasTheGivenSigmaAndNoMean) {
  const cv::Mat clean = OpenSyntheticDataset("corridor?noise=0&frames=2")->Read(0).left;
  for (const double sigma : {2.0, 4.0}) {
    const cv::Mat noisy = OpenSyntheticDataset("corridor?frames=2&noise=" + std::to_string(sigma))->Read(0).left;
    double sum = 0.0;
    double square = 0.0;
    int count = 0;
    for (int y = 0; y < clean.rows; ++y) {
      for (int x = 0; x < clean.cols; ++x) {
        const int value = clean.at<uint8_t>(y, x);
        if (value > 20 && value < 230) {
          const double difference = noisy.at<uint8_t>(y, x) - value;
          sum += difference;
          square += difference * difference;
          ++count;
        }
      }
    }
    EXPECT_NEAR(sum / count, 0.0, 0.03) << "sigma " << sigma;
    // Both images are rounded: 1/12 each.
    EXPECT_NEAR(std::sqrt(square / count - 1.0 / 6.0), sigma, 0.06 * sigma) << "sigma " << sigma;
  }
}

TEST(Synthetic, NoiseOfLeftRightAndNextFrameIsIndependent) {
  // A standing camera: the same view with other noise.
  const auto dataset = OpenSyntheticDataset("corridor?exposure=0&frames=3&speed=0.01&rate=1000&noise=4&size=320x240");
  const auto still = OpenSyntheticDataset("corridor?exposure=0&frames=3&speed=0.01&rate=1000&noise=0&size=320x240");
  cv::Mat a;
  cv::Mat b;
  cv::subtract(dataset->Read(0).left, still->Read(0).left, a, cv::noArray(), CV_32F);
  cv::subtract(dataset->Read(1).left, still->Read(1).left, b, cv::noArray(), CV_32F);
  EXPECT_LT(std::abs(a.dot(b)) / std::sqrt(a.dot(a) * b.dot(b)), 0.02);
}

TEST(Synthetic, ExposureChangesSlowly) {
  const synthetic::Simulator on(synthetic::ParseOptions("room?size=64x48&frames=400"));
  const synthetic::Simulator off(synthetic::ParseOptions("room?size=64x48&frames=400&exposure=0"));
  double least = 1.0;
  double most = 1.0;
  for (int i = 0; i < 400; ++i) {
    least = std::min(least, on.Gain(i));
    most = std::max(most, on.Gain(i));
    EXPECT_EQ(off.Gain(i), 1.0);
    EXPECT_LT(i == 0 ? 0.0 : std::abs(on.Gain(i) - on.Gain(i - 1)), 0.02);
  }
  EXPECT_LT(least, 0.85);
  EXPECT_GT(most, 1.15);
}

TEST(Synthetic, BlurSmoothes) {
  const auto energy = [](const std::string& description) {
    const cv::Mat image = OpenSyntheticDataset(description)->Read(60).left;
    double sum = 0.0;
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 1; x < image.cols; ++x) {
        sum += std::abs(image.at<uint8_t>(y, x) - image.at<uint8_t>(y, x - 1));
      }
    }
    return sum;
  };
  EXPECT_LT(energy("room?noise=0&blur=1"), 0.9 * energy("room?noise=0"));
}

TEST(Synthetic, InertialSensor) {
  const auto exact = OpenSyntheticDataset("room?frames=5&imu=200&imu_class=exact&standing=1");
  ASSERT_TRUE(exact->rig().imu);
  EXPECT_EQ(exact->rig().imu->rate_hz, 200.0);
  EXPECT_LT(exact->ImuSamples().front().t_ns, 0);
  EXPECT_GT(exact->ImuSamples().back().t_ns, exact->t_ns(4));
  for (const ImuSample& sample : exact->ImuSamples()) {
    EXPECT_LT(sample.rate_rad_s.norm(), 1e-12) << "it stands";
    EXPECT_NEAR(sample.force_m_s2.norm(), 9.81, 1e-9);
    EXPECT_GT(sample.force_m_s2.z(), 9.7) << "nearly level: z is up";
  }
  const auto noisy = OpenSyntheticDataset("room?frames=5&imu=200&standing=1");
  const auto again = OpenSyntheticDataset("room?frames=5&imu=200&standing=1");
  EXPECT_EQ(noisy->ImuSamples(), again->ImuSamples());
  EXPECT_NE(noisy->ImuSamples(), OpenSyntheticDataset("room?frames=5&imu=200&standing=1&seed=2")->ImuSamples());
  EXPECT_FALSE(OpenSyntheticDataset("room?frames=5")->rig().imu);
  EXPECT_THROW(OpenSyntheticDataset("room?imu_class=exact"), DatasetError);
  EXPECT_THROW(OpenSyntheticDataset("room?imu=200&trajectory=poses.txt"), DatasetError);
  EXPECT_THROW(OpenSyntheticDataset("room?imu=200&imu_class=bmi056"), DatasetError);
}

}  // namespace
}  // namespace plslam
