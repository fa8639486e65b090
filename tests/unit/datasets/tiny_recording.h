// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/io/files/bytes.h"

namespace plslam::test {

/// How a tiny recording is written.
struct RecordingOptions {
  std::string compression{};  ///< of chunks: none, "lz4", "zstd" or "bz2"
  bool checksums = true;      ///< MCAP only
  bool unsorted = false;      ///< frames from the last to the first
  int indexed_chunks = 3;     ///< MCAP only: those that the summary names
  std::string left = "/cam0/image_raw";
  std::string right = "/cam1/image_raw";
  std::string encoding = "mono8";
  std::string image_type = "Image";
  double p_right = -5.0;    ///< P[3] of the right camera: baseline 0.125 m
  double skew_right = 0.0;  ///< P[1] of the right camera
  uint32_t info_scale = 1;  ///< camera_info is of a sensor so many times as wide and high
  uint32_t binning = 0;
};

/// The channels of a tiny recording, by their ids.
enum TinyChannel : uint16_t { kLeft, kRight, kLeftInfo, kRightInfo, kTruth };

/// Bytes of a record or of a message, one value after the other.
class RecordBytes {
 public:
  template <class Number>
  RecordBytes& Add(Number value) {
    AppendLittleEndian(value, bytes_);
    return *this;
  }
  RecordBytes& Text(const std::string& text) {
    Add(static_cast<uint32_t>(text.size()));
    bytes_ += text;
    return *this;
  }
  RecordBytes& Raw(const std::string& bytes) {
    bytes_ += bytes;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Topic and type ("sensor_msgs", "Image") of each channel.
struct TinyTopic {
  std::string topic, package, type;
};
std::vector<TinyTopic> TinyTopics(const RecordingOptions& options);

/// The messages of a frame, in ROS 1's encoding or in CDR.
std::map<uint16_t, std::string> TinyMessages(int64_t t_ns, int frame, const RecordingOptions& options, bool is_ros1);

std::string CompressedChunk(const std::string& in, const std::string& compression);

}  // namespace plslam::test
