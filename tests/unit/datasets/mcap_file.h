// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

namespace plslam::test {

/// How a tiny recording is written.
struct McapFileOptions {
  std::string compression{};  ///< of chunks: none, "lz4" or "zstd"
  bool checksums = true;
  bool unsorted = false;  ///< frames from the last to the first
  std::string left = "/cam0/image_raw";
  std::string right = "/cam1/image_raw";
  std::string encoding = "mono8";
  double p_right = -5.0;  ///< P[3] of the right camera: baseline 0.125 m
};

/// A tiny valid recording of ROS 2 in MCAP: three frames of `TinyPixel`, 100 ms apart, a chunk each, camera_info, and
/// the pose (i, 0, 0) of frame i on /ground_truth.
void MakeMcapFile(const std::filesystem::path& path, const McapFileOptions& options = {});

}  // namespace plslam::test
