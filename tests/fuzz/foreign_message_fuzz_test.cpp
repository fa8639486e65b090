// SPDX-License-Identifier: BSD-3-Clause
// Mutates messages of other programs, as received by the adapter: images, pairs of them and calibrations are rejected
// with a sentence, or are consistent, within a bound of memory.
#include <gtest/gtest.h>

#include "adapter/node/foreign_layouts.h"
#include "adapter/node/foreign_messages.h"
#include "bot_core/images_t.hpp"
#include "core/bus/transport/stock_lcm.h"
#include "core/files/dataset_error.h"
#include "core/io/images/jpeg_codec.h"
#include "core/robot/foreign_image.h"
#include "sensor_msgs/CameraInfo.hpp"
#include "sensor_msgs/CompressedImage.hpp"
#include "sensor_msgs/Image.hpp"
#include "tests/fuzz/message_mutator.h"
#include "tests/support/fuzzing.h"
#include "tests/unit/bus/allocation_counter.h"
#include "tests/unit/bus/random_message.h"

namespace plslam::adapter {
namespace {

using ByteVector = std::vector<uint8_t>;
using Random = std::mt19937_64;
using test::Fuzz;

constexpr int kWidth = 32, kHeight = 16;
const cv::Size kSize(kWidth, kHeight);

ByteVector Pixels() { return ByteVector(size_t{kWidth} * kHeight, 7); }

ByteVector Jpeg() {
  const std::string file = EncodeJpeg(cv::Mat(kSize, CV_8UC1, cv::Scalar(90)), 80);
  return {file.begin(), file.end()};
}

bot_core::image_t BotImage(bool jpeg) {
  bot_core::image_t image{};
  image.width = kWidth;
  image.height = kHeight;
  image.row_stride = jpeg ? 0 : kWidth;
  image.pixelformat = jpeg ? 1196444237 : 1497715271;
  image.data = jpeg ? Jpeg() : Pixels();
  image.size = static_cast<int32_t>(image.data.size());
  return image;
}

ByteVector SomeMessage(Random& random) {
  switch (random() % 4) {
    case 0: {
      bot_core::images_t pair{};
      pair.image_types = {0, 1};
      pair.images = {BotImage(random() % 2 == 0), BotImage(random() % 2 == 0)};
      pair.n_images = 2;
      return bus::Encoded(pair);
    }
    case 1: {
      sensor_msgs::Image image{};
      image.width = image.step = kWidth;
      image.height = kHeight;
      image.encoding = "mono8";
      image.data = Pixels();
      image.data_length = static_cast<int32_t>(image.data.size());
      return bus::Encoded(image);
    }
    case 2: {
      sensor_msgs::CompressedImage image{};
      image.data = Jpeg();
      image.data_length = static_cast<int32_t>(image.data.size());
      return bus::Encoded(image);
    }
    default: {
      const auto layouts = ForeignLayouts();
      return bus::test::RandomMessage(layouts[random() % layouts.size()], random);
    }
  }
}

/// Returns whether images were decoded, which then have the expected size.
bool Take(const ByteVector& bytes) {
  const auto take = [](const auto& f) {
    try {
      f();
      return true;
    } catch (const DatasetError& error) {
      EXPECT_STRNE(error.what(), "");
      return false;
    }
  };
  constexpr int kWhite = 65535;
  const auto expect_grey = [](const robot::ForeignImage& image) {
    ASSERT_EQ(robot::GreyOf(image, kSize, kWhite).size(), kSize);
  };
  const bool pair = take([&] {
    const auto [left, right] = PairFromBytes(bytes);
    expect_grey(left);
    expect_grey(right);
  });
  const bool image = take([&] { expect_grey(ImageFromBytes(bytes)); });
  take([&] {
    const RosCameraInfo info = CameraInfoFromBytes(bytes);
    RigFromRos(InPixelsOfImages(info, {}), InPixelsOfImages(info, {}), false);
  });
  take([&] { ASSERT_TRUE(RobotPoseFromBytes(bytes).T_robot_b.IsFinite()); });
  take([&] { ASSERT_TRUE(ImuSampleFromBytes(bytes).force_m_s2.allFinite()); });
  return pair || image;
}

TEST(ForeignMessageFuzz, ImagesAreRefusedOrWhole) {
  const test::FuzzCounts counts = Fuzz([](Random& random) {
    ByteVector bytes = SomeMessage(random);
    test::Mutate(bytes, random);
    return Take(bytes);
  });
  EXPECT_GT(counts.accepted, counts.cases / 100);
}

TEST(ForeignMessageFuzz, CheckedBytesDecodeWithinABound) {
  Fuzz([](Random& random) {
    ByteVector bytes = SomeMessage(random);
    test::Mutate(bytes, random);
    bus::test::allocated = 0;
    try {
      PairFromBytes(bytes);
    } catch (const DatasetError&) {
    }
    try {
      ImageFromBytes(bytes);
    } catch (const DatasetError&) {
    }
    ASSERT_LE(bus::test::allocated, 64 * bytes.size() + 10'000);
  });
}

}  // namespace
}  // namespace plslam::adapter
