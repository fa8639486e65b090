// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/tiny_recording.h"

#include <bzlib.h>
#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <utility>

#include "tests/unit/datasets/dataset_folders.h"

namespace plslam::test {
namespace {

/// A message: in CDR numbers are aligned to multiples of their sizes after the four bytes of the encoding, and texts
/// end with a zero that is counted.
class RosBytes {
 public:
  explicit RosBytes(bool is_ros1) : is_ros1_(is_ros1), bytes_(is_ros1 ? "" : std::string("\0\1\0\0", 4)) {}

  template <class T>
  RosBytes& Number(T value) {
    while (!is_ros1_ && (bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\0';
    AppendLittleEndian(value, bytes_);
    return *this;
  }
  RosBytes& Text(const std::string& text) {
    const std::string written = is_ros1_ ? text : text + '\0';
    Number(static_cast<uint32_t>(written.size()));
    bytes_ += written;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  bool is_ros1_;
  std::string bytes_;
};

void AddHeader(bool is_ros1, int64_t t_ns, const std::string& frame, RosBytes& message) {
  if (is_ros1) message.Number(uint32_t{7});  // which of them it is
  message.Number(static_cast<uint32_t>(t_ns / 1'000'000'000)).Number(static_cast<uint32_t>(t_ns % 1'000'000'000));
  message.Text(frame);
}

RosBytes Message(bool is_ros1, int64_t t_ns, const std::string& frame = "camera") {
  RosBytes message(is_ros1);
  AddHeader(is_ros1, t_ns, frame, message);
  return message;
}

std::string Image(bool is_ros1, int64_t t_ns, int frame, int camera, const std::string& encoding) {
  RosBytes message = Message(is_ros1, t_ns);
  message.Number(uint32_t{kTinyHeight_px}).Number(uint32_t{kTinyWidth_px}).Text(encoding).Number(uint8_t{0});
  const bool is_wide = encoding == "mono16" || encoding == "16UC1";  // of 10 bits
  const bool is_float = encoding == "32FC1";                         // hundredths
  const uint32_t bytes = encoding == "rgb8" ? 3 : is_wide ? 2 : is_float ? 4 : 1;
  message.Number(uint32_t{kTinyWidth_px} * bytes).Number(uint32_t{kTinyWidth_px} * kTinyHeight_px * bytes);
  for (int y = 0; y < kTinyHeight_px; ++y) {
    for (int x = 0; x < kTinyWidth_px; ++x) {
      const int pixel = TinyPixel(frame, camera, x, y), ten_bits = 4 * pixel + 2;
      if (is_wide) message.Number(static_cast<uint8_t>(ten_bits & 255)).Number(static_cast<uint8_t>(ten_bits >> 8));
      if (is_float) message.Number(0.01F * static_cast<float>(pixel));
      for (uint32_t c = 0; !is_wide && !is_float && c < bytes; ++c) message.Number(static_cast<uint8_t>(pixel));
    }
  }
  return message.bytes();
}

std::string CameraInfo(bool is_ros1, int64_t t_ns, int frame, double p1, double p3, const RecordingOptions& o) {
  RosBytes message = Message(is_ros1, t_ns);
  message.Number(o.info_scale * kTinyHeight_px).Number(o.info_scale * kTinyWidth_px);
  message.Text("plumb_bob").Number(static_cast<uint32_t>(o.distortion.size()));
  for (const double d : o.distortion) message.Number(d);
  const double s = o.info_scale, on = o.info_factor ? o.info_factor(frame) : 1.0;
  for (const double k : {40 * s, 0.0, 24 * s, 0.0, 40 * s, 16 * s, 0.0, 0.0, 1.0}) message.Number(on * k);
  for (const double r : {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}) message.Number(r);
  for (const double p : {40 * s, p1, 24 * s, p3 * s, 0.0, 40 * s, 16 * s, 0.0, 0.0, 0.0, 1.0, 0.0}) {
    message.Number(on * p);
  }
  message.Number(o.binning).Number(o.binning);
  for (int i = 0; i < 4; ++i) message.Number(uint32_t{0});  // the whole sensor
  message.Number(uint8_t{0});
  return message.bytes();
}

std::string Pose(bool is_ros1, int64_t t_ns, int frame) {
  RosBytes message = Message(is_ros1, t_ns);
  for (const double x : {1.0 * frame, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0}) message.Number(x);
  return message.bytes();
}

std::string Imu(bool is_ros1, const TinyImuTopic& topic, const ImuSample& sample) {
  RosBytes message = Message(is_ros1, sample.t_ns, topic.frame);
  const auto add_covariance = [&](bool is_measured) {
    for (int i = 0; i < 9; ++i) message.Number(i == 0 && !is_measured ? -1.0 : 0.0);
  };
  for (const double q : {0.0, 0.0, 0.0, 1.0}) message.Number(q);
  add_covariance(false);
  for (const double rate : sample.rate_rad_s) message.Number(rate);
  add_covariance(topic.has_rate);
  for (const double force : sample.force_m_s2) message.Number(force);
  add_covariance(topic.has_force);
  return message.bytes();
}

/// The camera is at the origin of the frame "mast". The first transform is that of a tool without a rotation. Names of
/// frames of ROS 1 begin with a slash, as in old bags.
std::string StaticTransforms(bool is_ros1, const SE3& T_camera_imu) {
  RosBytes message(is_ros1);
  const std::string slash = is_ros1 ? "/" : "";
  message.Number(uint32_t{3});
  const auto add = [&](const std::string& child, const Eigen::Vector3d& t, const Eigen::Vector4d& q_xyzw) {
    AddHeader(is_ros1, 0, slash + "mast", message);
    message.Text(slash + child);
    for (const double x : t) message.Number(x);
    for (const double x : q_xyzw) message.Number(x);
  };
  add("tool", {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0});
  add("camera", {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0});
  add("imu", T_camera_imu.translation(), T_camera_imu.rotation().coeffs());
  return message.bytes();
}

/// The messages beside those of the cameras.
std::vector<TinyMessage> SensorMessages(const RecordingOptions& o, bool is_ros1) {
  std::vector<TinyMessage> messages;
  uint16_t channel = kTruth + 1;
  if (o.T_camera_imu) messages.push_back({channel++, 1'000'000'000, StaticTransforms(is_ros1, *o.T_camera_imu)});
  for (const TinyImuTopic& topic : o.imus) {
    for (const ImuSample& sample : topic.samples) {
      messages.push_back({channel, sample.t_ns, Imu(is_ros1, topic, sample)});
    }
    ++channel;
  }
  return messages;
}

}  // namespace

std::vector<std::vector<TinyMessage>> TinyChunks(const RecordingOptions& o, bool is_ros1) {
  std::vector<TinyMessage> all;
  for (int i = 0; i < o.n_frames; ++i) {
    const int frame = o.unsorted ? o.n_frames - 1 - i : i;
    const int64_t t_ns = 1'000'000'000 + 100'000'000 * int64_t{frame};
    for (const uint16_t channel : {kLeft, kRight, kLeftInfo, kRightInfo, kTruth}) {
      const int64_t stamp_ns = o.stamp ? o.stamp(channel, frame, t_ns) : t_ns;
      std::string bytes;
      if (channel == kLeft || channel == kRight) {
        const bool is_right = channel == kRight;
        const bool is_other = is_right && !o.right_encoding.empty();
        bytes = Image(is_ros1, stamp_ns, frame, is_right ? 1 : 0, is_other ? o.right_encoding : o.encoding);
      } else if (channel == kTruth) {
        bytes = Pose(is_ros1, stamp_ns, frame);
      } else {
        const bool is_right = channel == kRightInfo;
        bytes = CameraInfo(is_ros1, stamp_ns, frame, is_right ? o.skew_right : 0.0, is_right ? o.p_right : 0.0, o);
      }
      all.push_back({channel, o.log_time ? o.log_time(channel, frame, t_ns) : t_ns, std::move(bytes)});
    }
  }
  for (TinyMessage& message : SensorMessages(o, is_ros1)) all.push_back(std::move(message));
  if (o.by_log_time) {
    std::stable_sort(all.begin(), all.end(),
                     [](const TinyMessage& a, const TinyMessage& b) { return a.log_ns < b.log_ns; });
  }
  std::vector<std::vector<TinyMessage>> chunks(static_cast<size_t>(o.n_frames));
  for (size_t i = 0; i < all.size(); ++i) chunks[i * chunks.size() / all.size()].push_back(std::move(all[i]));
  return chunks;
}

std::vector<TinyTopic> TinyTopics(const RecordingOptions& o) {
  const std::string left_space = o.left.substr(0, o.left.rfind('/'));
  const std::string right_space = o.right.substr(0, o.right.rfind('/'));
  std::vector<TinyTopic> topics{{o.left, "sensor_msgs", o.image_type},
                                {o.right, "sensor_msgs", o.image_type},
                                {left_space + "/camera_info", "sensor_msgs", "CameraInfo"},
                                {right_space + "/camera_info", "sensor_msgs", "CameraInfo"},
                                {"/ground_truth", "geometry_msgs", "PoseStamped"}};
  if (o.T_camera_imu) topics.push_back({"/tf_static", "tf2_msgs", "TFMessage"});
  for (const TinyImuTopic& imu : o.imus) topics.push_back({imu.topic, "sensor_msgs", "Imu"});
  return topics;
}

std::string CompressedChunk(const std::string& in, const std::string& compression) {
  if (compression.empty()) return in;
  std::string out(in.size() + 1000, '\0');
  if (compression == "bz2") {
    auto n = static_cast<unsigned>(out.size());
    std::string from = in;
    BZ2_bzBuffToBuffCompress(out.data(), &n, from.data(), static_cast<unsigned>(from.size()), 1, 0, 0);
    return out.substr(0, n);
  }
  const size_t n = compression == "lz4" ? LZ4F_compressFrame(out.data(), out.size(), in.data(), in.size(), nullptr)
                                        : ZSTD_compress(out.data(), out.size(), in.data(), in.size(), 1);
  return out.substr(0, n);
}

}  // namespace plslam::test
