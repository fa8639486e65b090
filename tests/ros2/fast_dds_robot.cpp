// SPDX-License-Identifier: BSD-3-Clause
// fast_dds_robot DATASET RATE_HZ N_FRAMES [OPTION...]: a robot of ROS 2 by Fast
// DDS. After a subscriber is found, it publishes the stereo images of a dataset on /stereo/left/image_raw and right,
// with CameraInfo (with colour and depth: on /camera); it hears what plslam_ros2 publishes, and prints what it heard as
// JSON. Options: no_info, no_right, other_clock, constant, unsynchronised, tf_static (a camera that looks to the left),
// late_tf_static (the same, from frame 20 on), lies (sizes that do not fit the data, and odometry that is not finite),
// reliable, jpeg, png, compressed_depth, big_endian, wheels (true odometry on
// /wheels), imu (samples of the dataset on /imu/data; with tf_static its frame is beside the camera), imu_apart (the
// same on /camera/gyro/sample and /camera/accel/sample), covered (black images for a second), synchronous (a written
// image has been sent; they are rendered before), different=N (only N images, again and again), listen_s=SECONDS
// (afterwards), begin_s=SECONDS (stamp of the first frame; by default that of the dataset and one second), space=/NAME (before all
// topics but /tf), census (counts the messages of all topics of plslam_ros2), hostile=N (first N damaged messages to each topic that plslam_ros2 reads, of
// the right types). After SIGTERM it sends nothing more.
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include <robotPubSubTypes.h>
#include "core/datasets/open_dataset.h"
#include "tests/ros2/fast_robot.h"
#include "tests/ros2/raw_messages.h"
#include "tests/ros2/robot_messages.h"

namespace plslam::test {
namespace {

using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr int kCoveredFrom = 40, kCoveredTo = 60;

volatile std::sig_atomic_t g_is_ended = 0;

/// The inertial sensor of a dataset: its samples in order, on one topic or on two.
class ImuDriver {
 public:
  using Type = sensor_msgs::msg::dds_::Imu_PubSubType;
  ImuDriver(Robot& robot, const std::vector<ImuSample>& samples, bool apart) : samples_(samples) {
    rates_ = robot.FastWriter<Type>(apart ? "/camera/gyro/sample" : "/imu/data");
    if (apart) forces_ = robot.FastWriter<Type>("/camera/accel/sample");
  }
  bool HasReaders() const {
    fast::PublicationMatchedStatus status;
    return rates_->get_publication_matched_status(status) == ReturnCode_t::RETCODE_OK && status.current_count > 0;
  }
  /// Publishes all up to the first one at or after `t_ns`. Every second force is left out where they are apart.
  void PublishUntil(int64_t t_ns, int64_t begin_ns) {
    for (bool is_after = false; next_ < samples_.size() && !is_after; ++next_) {
      const ImuSample& sample = samples_[next_];
      is_after = sample.t_ns >= t_ns && (forces_ == nullptr || next_ % 2 == 0);
      auto message = ImuOf(sample, sample.t_ns + begin_ns);
      if (forces_ != nullptr) {
        auto force = message;
        force.angular_velocity({});
        message.linear_acceleration({});
        if (next_ % 2 == 0) forces_->write(&force);
      }
      rates_->write(&message);
    }
  }

 private:
  const std::vector<ImuSample>& samples_;
  fast::DataWriter* rates_ = nullptr;
  fast::DataWriter* forces_ = nullptr;
  size_t next_ = 0;
};

void SendDamagedMessages(const RigCalibration& rig, const cv::Mat& grey, int n) {
  using namespace sensor_msgs::msg::dds_;
  SendDamaged<Image_PubSubType>("rt/stereo/left/image_raw", ImageOf(grey, 1'000'000), n);
  SendDamaged<CameraInfo_PubSubType>("rt/stereo/left/camera_info", InfoOf(rig, true, 1'000'000), n);
  SendDamaged<nav_msgs::msg::dds_::Odometry_PubSubType>("rt/wheels", OdometryOf(SE3(), 1'000'000), n);
  SendDamaged<Imu_PubSubType>("rt/imu/data", ImuOf({}, 1'000'000), n);
  tf2_msgs::msg::dds_::TFMessage_ frames;
  frames.transforms().resize(2);
  SendDamaged<tf2_msgs::msg::dds_::TFMessage_PubSubType>("rt/tf_static", frames, n);
}

/// A writer of generated messages, in this machine's order of bytes or the other one.
template <class Type>
fast::DataWriter* WriterOf(Robot& robot, const std::string& topic, bool is_big_endian, bool is_reliable) {
  return is_big_endian ? robot.Writer<BigEndian<Type>>(topic, is_reliable) : robot.Writer<Type>(topic, is_reliable);
}

/// Images of one camera, as they are or as files.
class ImageWriter {
 public:
  /// `format` as of `CompressedOf`; empty: images as they are.
  void Open(Robot& robot, const std::string& topic, const std::string& format, bool is_big_endian, bool is_reliable) {
    using namespace sensor_msgs::msg::dds_;
    format_ = format;
    const std::string end = format == "compressedDepth" ? "/compressedDepth" : "/compressed";
    writer_ = format.empty() ? WriterOf<Image_PubSubType>(robot, topic, is_big_endian, is_reliable)
                             : WriterOf<CompressedImage_PubSubType>(robot, topic + end, is_big_endian, is_reliable);
  }
  /// `change` gets images as they are.
  template <class Change>
  void Write(const cv::Mat& pixels, int64_t t_ns, Change change) {
    if (format_.empty()) {
      auto image = ImageOf(pixels, t_ns);
      change(image);
      writer_->write(&image);
    } else {
      auto image = CompressedOf(pixels, format_, t_ns);
      writer_->write(&image);
    }
  }
  fast::DataWriter* writer() const { return writer_; }

 private:
  std::string format_;
  fast::DataWriter* writer_ = nullptr;
};

template <class Pose>
json NumbersOf(const Pose& position, const geometry_msgs::msg::dds_::Quaternion_& q) {
  return {position.x(), position.y(), position.z(), q.x(), q.y(), q.z(), q.w()};
}

/// Listens to the topics of plslam_ros2 in a namespace, and to /tf and /tf_static, to which the robot may write itself.
class Ears {
 public:
  Ears(Robot& robot, const std::string& space) {
    odometry_ = robot.Reader<nav_msgs::msg::dds_::Odometry_PubSubType>(space + "/plslam/odom", false);
    poses_ =
        robot.Reader<geometry_msgs::msg::dds_::PoseWithCovarianceStamped_PubSubType>(space + "/plslam/pose", false);
    transforms_ = robot.Reader<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/tf", false);
    static_transforms_ = robot.Reader<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/tf_static", true);
    points_ = robot.Reader<sensor_msgs::msg::dds_::PointCloud2_PubSubType>(space + "/plslam/map/points", true);
    path_ = robot.Reader<nav_msgs::msg::dds_::Path_PubSubType>(space + "/plslam/path", true);
  }

  /// Adds what has arrived.
  void Listen(json& heard) {
    Take<nav_msgs::msg::dds_::Odometry_>(odometry_, [&](const auto& odom) {
      const auto& pose = odom.pose().pose();
      json row{StampOf(odom.header())};
      for (const json& number : NumbersOf(pose.position(), pose.orientation())) row.push_back(number);
      row.push_back(odom.pose().covariance()[0]);
      heard["odom"].push_back(row);
      heard["odom_frames"] = {odom.header().frame_id(), odom.child_frame_id()};
      heard["odom_covariance"] = odom.pose().covariance();
      heard["velocity_covariance"] = odom.twist().covariance();
    });
    Take<geometry_msgs::msg::dds_::PoseWithCovarianceStamped_>(poses_, [&](const auto& message) {
      const auto& pose = message.pose().pose();
      heard["pose"] = {{"n", heard["pose"].value("n", 0) + 1},
                       {"frame", message.header().frame_id()},
                       {"numbers", NumbersOf(pose.position(), pose.orientation())},
                       {"covariance", message.pose().covariance()}};
    });
    for (const auto& [reader, name] : {std::pair(transforms_, "tf"), std::pair(static_transforms_, "tf_static")}) {
      Take<tf2_msgs::msg::dds_::TFMessage_>(reader, [&, key = name](const auto& tf) {
        for (const auto& one : tf.transforms()) {
          const std::string frames = one.header().frame_id() + " " + one.child_frame_id();
          heard[key][frames] = heard[key].value(frames, 0) + 1;
        }
      });
    }
    Take<sensor_msgs::msg::dds_::PointCloud2_>(points_, [&](const auto& cloud) { heard["points"] = cloud.width(); });
    Take<nav_msgs::msg::dds_::Path_>(path_, [&](const auto& path) { heard["path"] = path.poses().size(); });
  }

  static json Nothing() {
    return {{"sent", 0},
            {"odom", json::array()},
            {"pose", json::object()},
            {"tf", json::object()},
            {"tf_static", json::object()},
            {"points", 0},
            {"path", 0}};
  }

 private:
  template <class Message, class Use>
  static void Take(fast::DataReader* reader, Use use) {
    Message message;
    fast::SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) use(message);
    }
  }

  fast::DataReader *odometry_ = nullptr, *poses_ = nullptr, *transforms_ = nullptr, *static_transforms_ = nullptr,
                   *points_ = nullptr, *path_ = nullptr;
};

/// Ends the process: destructors of Fast DDS wait for seconds.
[[noreturn]] void Run(int argc, char** argv) {
  std::signal(SIGTERM, [](int) { g_is_ended = 1; });
  const auto dataset = OpenDataset(argv[1], "");
  const double rate_hz = std::atof(argv[2]);
  const int n_frames = std::min(std::atoi(argv[3]), dataset->size());
  const std::set<std::string> options(argv + 4, argv + argc);
  double listen_s = 2.0;
  int n_hostile = 0, n_different = n_frames;
  std::string space;
  int64_t begin_ns = 1'000'000'000;
  for (const std::string& option : options) {
    if (option.rfind("listen_s=", 0) == 0) listen_s = std::atof(option.c_str() + 9);
    if (option.rfind("space=", 0) == 0) space = option.substr(6);
    if (option.rfind("hostile=", 0) == 0) n_hostile = std::atoi(option.c_str() + 8);
    if (option.rfind("different=", 0) == 0) n_different = std::atoi(option.c_str() + 10);
    if (option.rfind("begin_s=", 0) == 0) begin_ns = std::atoll(option.c_str() + 8) * 1'000'000'000;
  }
  const auto has = [&](const char* option) { return options.count(option) > 0; };

  std::vector<StereoImages> ready;
  for (int i = 0; has("synchronous") && i < std::min(n_frames, n_different); ++i) ready.push_back(dataset->Read(i));

  Robot robot;
  robot.is_synchronous = has("synchronous");
  const bool rgbd = dataset->rig().kind == RigCalibration::Kind::kRgbd;
  using Info = sensor_msgs::msg::dds_::CameraInfo_PubSubType;
  ImageWriter images[2];
  fast::DataWriter* infos[2] = {nullptr, nullptr};
  for (int i = 0; i < (has("no_right") ? 1 : 2); ++i) {
    const std::string side = space + (rgbd ? (i == 0 ? "/camera/color" : "/camera/aligned_depth_to_color")
                                           : (i == 0 ? "/stereo/left" : "/stereo/right"));
    std::string format;
    for (const char* name : {"jpeg", "png"}) {
      if (has(name)) format = name;
    }
    if (has("compressed_depth") && i == 1) format = "compressedDepth";
    images[i].Open(robot, side + "/image_raw", format, has("big_endian"), has("reliable"));
    if (!has("no_info")) infos[i] = WriterOf<Info>(robot, side + "/camera_info", has("big_endian"), true);
  }
  Ears ears(robot, space);
  std::optional<Census> census;
  if (has("census")) census.emplace("/plslam/");

  auto* const wheels =
      has("wheels") ? robot.Writer<nav_msgs::msg::dds_::Odometry_PubSubType>("/wheels", true) : nullptr;
  const auto write_mounting = [&] {
    auto mounting = MountingOf(dataset->rig());
    robot.LatchedWriter<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/tf_static")->write(&mounting);
  };
  if (has("tf_static")) write_mounting();
  std::unique_ptr<ImuDriver> imu;
  if (has("imu") || has("imu_apart")) {
    imu = std::make_unique<ImuDriver>(robot, dataset->ImuSamples(), has("imu_apart"));
  }

  json heard = Ears::Nothing();
  const auto begin = Clock::now();
  const auto now_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const auto listen = [&] {
    ears.Listen(heard);
    if (census) census->Listen();
  };

  // Discovery: a frame counts from when all topics have a subscriber.
  const auto matched = [&](fast::DataWriter* writer) {
    fast::PublicationMatchedStatus status;
    return writer == nullptr ||
           (writer->get_publication_matched_status(status) == ReturnCode_t::RETCODE_OK && status.current_count > 0);
  };
  const auto are_all_matched = [&] {
    // Depths have the camera of the colour image.
    return matched(images[0].writer()) && matched(images[1].writer()) && matched(infos[0]) &&
           (rgbd || matched(infos[1])) && (!imu || imu->HasReaders());
  };
  // The census reads topics from the time when it knows them.
  const auto wait_until = [&](double end_s, const auto& done) {
    while (now_s() < end_s && g_is_ended == 0 && !done()) {
      if (census) census->Listen();
      usleep(20'000);
    }
  };
  wait_until(10.0, are_all_matched);
  const auto write_info = [&](size_t side, int64_t t_ns) {
    if (infos[side] == nullptr) return;
    auto info = InfoOf(dataset->rig(), side == 0, t_ns);
    infos[side]->write(&info);
  };
  // Until they know it, too, and no longer wait for /tf_static, which they do for two seconds after CameraInfo.
  for (const double end_s = now_s() + (infos[0] == nullptr ? 1.5 : 3.7); now_s() < end_s && g_is_ended == 0;) {
    for (const size_t side : {0, 1}) write_info(side, begin_ns);
    wait_until(now_s() + 0.05, [] { return false; });
  }
  heard["discovery_s"] = now_s();
  const RigCalibration& rig = dataset->rig();
  if (n_hostile > 0) SendDamagedMessages(rig, dataset->Read(0).left, n_hostile);
  double due_s = now_s();
  for (int i = 0; i < n_frames && g_is_ended == 0; ++i) {
    const StereoImages frame = ready.empty() ? dataset->Read(i) : ready[static_cast<size_t>(i) % ready.size()];
    int64_t t_ns[2] = {dataset->t_ns(i) + begin_ns, dataset->t_ns(i) + begin_ns};
    if (has("other_clock")) t_ns[1] += 3600'000'000'000;
    if (has("unsynchronised")) t_ns[1] += 20'000'000;
    if (has("constant")) t_ns[0] = t_ns[1] = 7'000'000'000;
    listen();  // also where rendering takes longer than a period
    while (now_s() < due_s) {
      usleep(500);
      listen();
    }
    due_s += 1.0 / rate_hz;
    if (has("late_tf_static") && i == 20) write_mounting();
    if (imu) imu->PublishUntil(dataset->t_ns(i), begin_ns);
    if (wheels != nullptr) {
      auto wheel_odometry = OdometryOf(dataset->GroundTruth(0)->Inverse() * *dataset->GroundTruth(i), t_ns[0]);
      if (has("lies")) wheel_odometry.pose().pose().position().x(NAN);
      wheels->write(&wheel_odometry);
    }
    for (int side = 0; side < 2; ++side) {
      if (images[side].writer() == nullptr) continue;
      write_info(static_cast<size_t>(side), t_ns[side]);
      cv::Mat pixels = side == 0 ? frame.left : frame.right;
      if (has("covered") && i >= kCoveredFrom && i < kCoveredTo)
        pixels = cv::Mat::zeros(pixels.size(), pixels.type());
      images[side].Write(pixels, t_ns[side], [&](sensor_msgs::msg::dds_::Image_& image) {
        if (has("lies") && i % 2 == 0) image.height(i % 4 == 0 ? 4'000'000'000U : 10'000U);
        if (has("lies") && i % 6 == 1) image.encoding("unknown16");
      });
    }
    // Stamped by the clock that all processes of this machine share.
    heard["sent_at_s"].push_back({t_ns[0], std::chrono::duration<double>(Clock::now().time_since_epoch()).count()});
    heard["sent"] = i + 1;
  }
  for (const double end_s = now_s() + listen_s; now_s() < end_s && g_is_ended == 0; usleep(1000)) {
    listen();
  }
  if (census) heard["topics"] = census->topics();
  std::printf("%s\n", heard.dump().c_str());
  std::fflush(stdout);
  std::_Exit(0);
}

}  // namespace
}  // namespace plslam::test

int main(int argc, char** argv) { plslam::test::Run(argc, argv); }
