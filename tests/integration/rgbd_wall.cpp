// SPDX-License-Identifier: BSD-3-Clause
#include "tests/integration/rgbd_wall.h"

#include <filesystem>
#include <fstream>
#include <random>

#include <fmt/format.h>
#include <opencv2/core.hpp>

#include "core/io/images/png_codec.h"

namespace plslam::test {

std::string WallOfAnRgbdCamera(const ScratchFolder& folder, int n_frames) {
  const std::filesystem::path wall = folder.Path("wall");
  for (const char* name : {"rgb", "depth"}) std::filesystem::create_directories(wall / name);
  std::ofstream(wall / "camera.yaml")
      << "kind: rgbd\nrate_hz: 20\ndepth_units_per_m: 1000\nleft:\n  resolution_px: [376, 240]\n"
         "  focal_length_px: [200, 200]\n  principal_point_px: [187.5, 119.5]\n";
  cv::Mat grains(40, 120, CV_8UC1);
  std::mt19937 random(5);
  for (int i = 0; i < grains.rows * grains.cols; ++i) grains.data[i] = static_cast<uint8_t>(random());
  for (int i = 0; i < n_frames; ++i) {
    cv::Mat image(240, 376, CV_8UC1);
    for (int y = 0; y < image.rows; ++y) {
      for (int x = 0; x < image.cols; ++x) image.at<uint8_t>(y, x) = grains.at<uint8_t>(y / 6, (x + 2 * i) / 6);
    }
    WritePng((wall / "rgb" / fmt::format("{:04}.png", i)).string(), image);
    WritePng((wall / "depth" / fmt::format("{:04}.png", i)).string(), cv::Mat(240, 376, CV_16UC1, cv::Scalar(2000)));
  }
  return wall.string();
}

}  // namespace plslam::test
