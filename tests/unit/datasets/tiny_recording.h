// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/files/bytes.h"
#include "core/geometry/imu.h"
#include "core/geometry/se3.h"

namespace plslam::test {

/// The messages of a topic of sensor_msgs/Imu, in this order.
struct TinyImuTopic {
  std::string topic;
  std::vector<ImuSample> samples;
  std::string frame = "imu";
  bool has_rate = true, has_force = true;
};

/// Format of a tiny recording.
struct RecordingOptions {
  std::string compression{};     ///< of chunks: none, "lz4", "zstd" or "bz2"
  bool checksums = true;         ///< MCAP only
  bool unsorted = false;         ///< frames from the last to the first
  int indexed_chunks = 1 << 30;  ///< MCAP only: those that the summary names
  int n_frames = 3;
  /// When a message of a frame was logged, and its header stamp: the time of the frame without them.
  std::function<int64_t(uint16_t channel, int frame, int64_t t_ns)> log_time{};
  std::function<int64_t(uint16_t channel, int frame, int64_t t_ns)> stamp{};
  bool by_log_time = false;  ///< messages are in the order of logging, not of frames
  std::string left = "/cam0/image_raw";
  std::string right = "/cam1/image_raw";
  std::string encoding = "mono8";
  std::string right_encoding{};  ///< empty: that of the left images
  std::string image_type = "Image";
  double p_right = -5.0;    ///< P[3] of the right camera: baseline 0.125 m
  double skew_right = 0.0;  ///< P[1] of the right camera
  uint32_t info_scale = 1;  ///< camera_info is of a sensor so many times as wide and high
  uint32_t binning = 0;
  std::vector<double> distortion{-0.28, 0.07, 0.0002, 1.8e-5, 0.0};
  std::function<double(int frame)> info_factor{};  ///< of K and P; 1 without
  std::vector<TinyImuTopic> imus{};
  /// Pose of the frame "imu" in the frame "camera", over a frame between them on /tf_static; none without.
  std::optional<SE3> T_camera_imu{};
};

/// The channels of a tiny recording, by their ids; those of /tf_static and of inertial sensors follow, if there are
/// any.
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

/// A message, in ROS 1's encoding or in CDR.
struct TinyMessage {
  uint16_t channel = 0;
  int64_t log_ns = 0;
  std::string bytes;
};
/// As many chunks as frames, and their messages in order.
std::vector<std::vector<TinyMessage>> TinyChunks(const RecordingOptions& options, bool is_ros1);

std::string CompressedChunk(const std::string& in, const std::string& compression);

}  // namespace plslam::test
