// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/datasets/calibrations/camera_info.h"
#include "core/files/dataset_error.h"
#include "core/geometry/imu.h"
#include "core/geometry/se3.h"
#include "core/geometry/static_frames.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// Serialisation of a message, always little endian: ROS 2's CDR (OMG DDS-XTypes, plain CDR), in which numbers are
/// aligned to their size, counted from after the four bytes that name the encoding; or ROS 1's, without alignment.
enum class RosEncoding { kCdr, kRos1 };

/// Returns the encoding that recordings call "cdr" or "ros1"; nullopt for others.
std::optional<RosEncoding> RosEncodingOf(std::string_view name);

/// Reads a message of ROS. Every read throws DatasetError where the message ends before.
class RosReader {
 public:
  explicit RosReader(std::span<const uint8_t> message, RosEncoding encoding)
      : bytes_(message), is_cdr_(encoding == RosEncoding::kCdr), at_(is_cdr_ ? kCdrHeadBytes : 0) {
    constexpr uint8_t kLittleEndian = 1;
    if (is_cdr_ && (bytes_.size() < kCdrHeadBytes || bytes_[0] != 0 || bytes_[1] != kLittleEndian)) {
      throw DatasetError("the message is not plain little-endian CDR");
    }
  }

  /// std_msgs/Header, which begins most messages.
  struct Header {
    int64_t t_ns = 0;
    std::string frame;
  };
  Header ReadHeader() {
    if (!is_cdr_) Get<uint32_t>();  // ROS 1 counts messages
    const int64_t seconds = Get<uint32_t>(), nanoseconds = Get<uint32_t>();
    return {seconds * 1'000'000'000 + nanoseconds, Text()};
  }
  void SkipHeader() { ReadHeader(); }

  template <class Number>
  Number Get() {
    static_assert(std::is_arithmetic_v<Number>);
    if (is_cdr_) {
      const size_t from = (at_ - kCdrHeadBytes) % sizeof(Number);
      if (from != 0) Take(sizeof(Number) - from);
    }
    Number value;
    std::memcpy(&value, Take(sizeof(Number)).data(), sizeof(Number));
    return value;
  }

  std::string Text() {
    const std::span<const uint8_t> bytes = Bytes();
    // In CDR the count includes the zero at the end.
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size() - (is_cdr_ && !bytes.empty() ? 1 : 0)};
  }

  /// A sequence of bytes, within the message.
  std::span<const uint8_t> Bytes() { return Take(Get<uint32_t>()); }

 private:
  static constexpr size_t kCdrHeadBytes = 4;

  std::span<const uint8_t> Take(size_t n) {
    if (n > bytes_.size() - at_) throw DatasetError("the message ends before its last field");
    at_ += n;
    return bytes_.subspan(at_ - n, n);
  }

  std::span<const uint8_t> bytes_;
  bool is_cdr_;
  size_t at_;
};

// Messages of ROS, as far as a stereo sequence needs them. All throw DatasetError for a damaged message.

/// Names of the types in ROS 2.
inline constexpr std::string_view kRosImage = "sensor_msgs/msg/Image";
inline constexpr std::string_view kRosCompressedImage = "sensor_msgs/msg/CompressedImage";
inline constexpr std::string_view kRosCameraInfo = "sensor_msgs/msg/CameraInfo";
inline constexpr std::string_view kRosOdometry = "nav_msgs/msg/Odometry";
inline constexpr std::string_view kRosPose = "geometry_msgs/msg/PoseStamped";
inline constexpr std::string_view kRosImu = "sensor_msgs/msg/Imu";
inline constexpr std::string_view kRosTransforms = "tf2_msgs/msg/TFMessage";

/// sensor_msgs/msg/CameraInfo.
RosCameraInfo ParseCameraInfo(std::span<const uint8_t> message, RosEncoding encoding);

/// The encoding of the pixels of an Image; empty for a CompressedImage (`type`).
std::string ImageEncoding(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding);

/// Grey pixels of an Image or a CompressedImage (`type`); `white` is the white level of 16 bits, and
/// `clipped`, if given, becomes the part of the pixels above.
cv::Mat ParseImage(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                   const cv::Size& expected, int white, double* clipped = nullptr);

/// Depths of an Image or a CompressedImage (`type`), as in depth_images.h.
cv::Mat ParseDepths(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                    const cv::Size& expected, double units_per_m);

/// The bright value of one with pixels of 16 bits (image_file.h), else 0.
int BrightWideValue(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding,
                    const cv::Size& expected);

/// Returns the size of an Image or a CompressedImage by its header; no pixel is decoded. 0 x 0 if it has none.
ImageSize SizeOfImage(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding);

/// A sensor_msgs/msg/Imu. A covariance that begins with -1 means that its quantity was not measured.
struct RosImu {
  ImuSample sample;
  std::string frame;
  bool has_rate = true;
  bool has_force = true;
};
/// Throws DatasetError also for numbers that are not finite.
RosImu ParseImu(std::span<const uint8_t> message, RosEncoding encoding);

/// Adds the transforms of a TFMessage, the valid ones also if it throws DatasetError for another one. Names of frames
/// have no slash at their begin, as in ROS 2.
void ParseTransforms(std::span<const uint8_t> message, RosEncoding encoding, StaticFrames* frames);

/// Returns the frame of the header of a message.
std::string FrameOf(std::span<const uint8_t> message, RosEncoding encoding);

/// Returns the pose of an Odometry or a PoseStamped (`type`).
SE3 ParsePose(std::string_view type, std::span<const uint8_t> message, RosEncoding encoding);

}  // namespace plslam
