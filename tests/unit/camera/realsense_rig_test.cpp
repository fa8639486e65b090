// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>

#include "camera/camera_source.h"
#include "camera/pipeline_text.h"
#include "camera/rig_file.h"
#include "tests/support/data_folder.h"
#include "tests/support/text_file.h"
#include "tests/unit/camera/gst_elements.h"

namespace plslam::camera {
namespace {

/// The pipeline of the example reads a file of raw bytes instead of the device.
TEST(RealsenseRig, SeparatesTheBytesOfLeftAndRight) {
  PLSLAM_REQUIRE_ELEMENTS("rawvideoparse", "videobox", "videoscale");
  LiveRig live = ReadRigFileForPipeline((test::SourceFolder() / "config" / "rigs" / "realsense_d4xx.yaml").string());
  const int width = live.rig.left.width_px, height = live.rig.left.height_px;
  const ScratchFolder folder;
  const auto left_byte = [](int i) { return static_cast<char>(i % 251); };
  const auto right_byte = [](int i) { return static_cast<char>(255 - i % 241); };
  std::string bytes;
  for (int i = 0; i < width * height; ++i) bytes += {left_byte(i), right_byte(i)};
  const std::string file = folder.Write("y8i", bytes + bytes);
  std::string& pipeline = live.source.inputs[0];
  const std::string device = "v4l2src device=/dev/video42";
  ASSERT_NE(pipeline.find(device), std::string::npos);
  pipeline.replace(
      pipeline.find(device), device.size(),
      fmt::format("filesrc location=\"{}\" ! rawvideoparse format=gray8 width={} height={} framerate=30/1", file,
                  2 * width, height));
  CameraSource::Listener listener;
  listener.on_frame = [](const CaptureHealth&, const Pairing&) {};
  listener.on_outage = [](const std::string&) {};
  CameraSource source(live, false, listener);
  source.Begin(std::nullopt);
  for (int frame = 0; frame < 2; ++frame) {
    const auto loaded = source.Next();
    ASSERT_TRUE(loaded);
    const cv::Mat& left = loaded->images.left;
    const cv::Mat& right = loaded->images.right;
    ASSERT_EQ(left.cols, width);
    ASSERT_EQ(right.rows, height);
    int wrong = 0;
    for (int i = 0; i < width * height; ++i) {
      wrong += left.at<uint8_t>(i / width, i % width) == static_cast<uint8_t>(left_byte(i)) ? 0 : 1;
      wrong += right.at<uint8_t>(i / width, i % width) == static_cast<uint8_t>(right_byte(i)) ? 0 : 1;
    }
    EXPECT_EQ(wrong, 0) << "no byte is scaled or exchanged";
  }
}

}  // namespace
}  // namespace plslam::camera
