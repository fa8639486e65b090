// SPDX-License-Identifier: BSD-3-Clause
// fast_dds_robot DATASET RATE_HZ N_FRAMES [OPTION...]: a robot of ROS 2 by Fast
// DDS. After a subscriber is found, it publishes the stereo images of a dataset on /stereo/left/image_raw and right,
// with CameraInfo; it hears odometry, transforms, path and points, and prints what it heard as JSON. Options: no_info,
// no_right, other_clock, constant, unsynchronised, tf_static (a camera that looks to the left), lies (sizes that do
// not fit the data), reliable, jpeg, wheels (true odometry on /wheels), imu (samples of the dataset on /imu/data; with
// tf_static its frame is beside the camera), imu_apart (the same on /camera/gyro/sample and /camera/accel/sample),
// covered (black images for a second), synchronous (a written image has been sent; they are rendered before),
// listen_s=SECONDS (afterwards), begin_s=SECONDS (stamp of the first frame), space=/NAME (before all topics but /tf),
// hostile=N (first N damaged messages to each topic that plslam_ros2 reads, of the right types).
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <nlohmann/json.hpp>

#include <robotPubSubTypes.h>
#include "core/datasets/open_dataset.h"
#include "core/io/images/jpeg_codec.h"

namespace {

namespace fast = eprosima::fastdds::dds;
using Clock = std::chrono::steady_clock;
using nlohmann::json;

constexpr int kCoveredFrom = 40, kCoveredTo = 60;

class Robot {
 public:
  Robot() {
    const char* const domain = std::getenv("ROS_DOMAIN_ID");
    participant_ = fast::DomainParticipantFactory::get_instance()->create_participant(
        domain == nullptr ? 0 : static_cast<uint32_t>(std::atoi(domain)), fast::PARTICIPANT_QOS_DEFAULT);
    publisher_ = participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
  }

  template <class Type>
  fast::Topic* Topic(const std::string& name) {
    fast::TypeSupport type(new Type());
    type.register_type(participant_);
    return participant_->create_topic("rt" + name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
  }
  bool is_synchronous = false;

  template <class Type>
  fast::DataWriter* Writer(const std::string& name, bool is_reliable) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = is_reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
    qos.history().depth = 5;
    qos.publish_mode().kind = is_synchronous ? fast::SYNCHRONOUS_PUBLISH_MODE : fast::ASYNCHRONOUS_PUBLISH_MODE;
    return publisher_->create_datawriter(Topic<Type>(name), qos);
  }
  /// Returns a writer of samples that come in bursts.
  template <class Type>
  fast::DataWriter* FastWriter(const std::string& name) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 500;
    qos.publish_mode().kind = fast::SYNCHRONOUS_PUBLISH_MODE;
    return publisher_->create_datawriter(Topic<Type>(name), qos);
  }
  template <class Type>
  fast::DataWriter* LatchedWriter(const std::string& name) {
    fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    return publisher_->create_datawriter(Topic<Type>(name), qos);
  }
  template <class Type>
  fast::DataReader* Reader(const std::string& name, bool is_latched) {
    fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 200;
    if (is_latched) qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
    return subscriber_->create_datareader(Topic<Type>(name), qos);
  }

 private:
  fast::DomainParticipant* participant_ = nullptr;
  fast::Publisher* publisher_ = nullptr;
  fast::Subscriber* subscriber_ = nullptr;
};

void SetHeader(std_msgs::msg::dds_::Header_& header, int64_t t_ns, const char* frame) {
  header.stamp().sec(static_cast<int32_t>(t_ns / 1'000'000'000));
  header.stamp().nanosec(static_cast<uint32_t>(t_ns % 1'000'000'000));
  header.frame_id(frame);
}

int64_t StampOf(const std_msgs::msg::dds_::Header_& header) {
  return int64_t{header.stamp().sec()} * 1'000'000'000 + header.stamp().nanosec();
}

/// A grey image, or depths in millimetres.
sensor_msgs::msg::dds_::Image_ ImageOf(const cv::Mat& grey, int64_t t_ns) {
  sensor_msgs::msg::dds_::Image_ image;
  SetHeader(image.header(), t_ns, "camera");
  image.width(static_cast<uint32_t>(grey.cols));
  image.height(static_cast<uint32_t>(grey.rows));
  image.step(static_cast<uint32_t>(grey.step));
  image.encoding(grey.type() == CV_8UC1 ? "mono8" : "16UC1");
  image.data(std::vector<uint8_t>(grey.datastart, grey.dataend));
  return image;
}

sensor_msgs::msg::dds_::CompressedImage_ JpegOf(const cv::Mat& grey, int64_t t_ns) {
  sensor_msgs::msg::dds_::CompressedImage_ image;
  SetHeader(image.header(), t_ns, "camera");
  image.format("mono8; jpeg compressed ");
  const std::string file = plslam::EncodeJpeg(grey, 95);
  image.data(std::vector<uint8_t>(file.begin(), file.end()));
  return image;
}

sensor_msgs::msg::dds_::CameraInfo_ InfoOf(const plslam::CameraCalibration& c, double baseline_m, int64_t t_ns) {
  sensor_msgs::msg::dds_::CameraInfo_ info;
  SetHeader(info.header(), t_ns, "camera");
  info.width(static_cast<uint32_t>(c.width_px));
  info.height(static_cast<uint32_t>(c.height_px));
  info.distortion_model("plumb_bob");
  info.d({0, 0, 0, 0, 0});
  info.k({c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1});
  info.r({1, 0, 0, 0, 1, 0, 0, 0, 1});
  info.p({c.fx_px, 0, c.cx_px, -c.fx_px * baseline_m, 0, c.fy_px, c.cy_px, 0, 0, 0, 1, 0});
  return info;
}

/// The pose of a body whose camera looks along x, relative to that of the first frame; from true poses.
nav_msgs::msg::dds_::Odometry_ OdometryOf(const plslam::SE3& T_first_c, int64_t t_ns) {
  const plslam::SE3 T_b_c(Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Eigen::Vector3d::Zero());
  const plslam::SE3 T_robot_b = T_b_c * T_first_c * T_b_c.Inverse();
  nav_msgs::msg::dds_::Odometry_ odometry;
  SetHeader(odometry.header(), t_ns, "wheels");
  odometry.child_frame_id("base_link");
  auto& pose = odometry.pose().pose();
  pose.position().x(T_robot_b.translation().x());
  pose.position().y(T_robot_b.translation().y());
  pose.position().z(T_robot_b.translation().z());
  pose.orientation().x(T_robot_b.rotation().x());
  pose.orientation().y(T_robot_b.rotation().y());
  pose.orientation().z(T_robot_b.rotation().z());
  pose.orientation().w(T_robot_b.rotation().w());
  return odometry;
}

sensor_msgs::msg::dds_::Imu_ ImuOf(const plslam::ImuSample& sample, int64_t t_ns) {
  sensor_msgs::msg::dds_::Imu_ imu;
  SetHeader(imu.header(), t_ns, "imu_link");
  imu.orientation_covariance()[0] = -1.0;
  imu.angular_velocity().x(sample.rate_rad_s.x());
  imu.angular_velocity().y(sample.rate_rad_s.y());
  imu.angular_velocity().z(sample.rate_rad_s.z());
  imu.linear_acceleration().x(sample.force_m_s2.x());
  imu.linear_acceleration().y(sample.force_m_s2.y());
  imu.linear_acceleration().z(sample.force_m_s2.z());
  return imu;
}

/// The inertial sensor of a dataset: its samples in order, on one topic or on two.
class ImuDriver {
 public:
  using Type = sensor_msgs::msg::dds_::Imu_PubSubType;
  ImuDriver(Robot& robot, const std::vector<plslam::ImuSample>& samples, bool apart) : samples_(samples) {
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
      const plslam::ImuSample& sample = samples_[next_];
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
  const std::vector<plslam::ImuSample>& samples_;
  fast::DataWriter* rates_ = nullptr;
  fast::DataWriter* forces_ = nullptr;
  size_t next_ = 0;
};

/// The left camera is 0.3 m in front of the body's origin and 0.2 m above it, and looks to the left.
void PublishMounting(Robot& robot, const plslam::RigCalibration& rig) {
  tf2_msgs::msg::dds_::TFMessage_ message;
  message.transforms().resize(rig.imu ? 3 : 2);
  if (rig.imu) {
    const plslam::SE3 T = rig.left.T_b_cam.Inverse() * rig.imu->T_b_imu;
    auto& imu = message.transforms()[2];
    SetHeader(imu.header(), 0, "camera");
    imu.child_frame_id("imu_link");
    imu.transform().translation().x(T.translation().x());
    imu.transform().translation().y(T.translation().y());
    imu.transform().translation().z(T.translation().z());
    imu.transform().rotation().x(T.rotation().x());
    imu.transform().rotation().y(T.rotation().y());
    imu.transform().rotation().z(T.rotation().z());
    imu.transform().rotation().w(T.rotation().w());
  }
  auto& mast = message.transforms()[0];
  SetHeader(mast.header(), 0, "base_link");
  mast.child_frame_id("mast");
  mast.transform().translation().x(0.3);
  mast.transform().translation().z(0.2);
  mast.transform().rotation().z(std::sqrt(0.5));
  mast.transform().rotation().w(std::sqrt(0.5));
  auto& optical = message.transforms()[1];
  SetHeader(optical.header(), 0, "mast");
  optical.child_frame_id("camera");
  optical.transform().rotation().x(-0.5);
  optical.transform().rotation().y(0.5);
  optical.transform().rotation().z(-0.5);
  optical.transform().rotation().w(0.5);
  auto* const writer = robot.LatchedWriter<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/tf_static");
  writer->write(&message);
}

/// Messages as they are, under the name of a type.
class RawType : public fast::TopicDataType {
 public:
  explicit RawType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = kMostBytes;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<std::vector<uint8_t>*>(data);
    std::copy(bytes.begin(), bytes.end(), payload->data);
    payload->length = static_cast<uint32_t>(bytes.size());
    payload->encapsulation = bytes.size() > 1 ? bytes[1] : 0;
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t* /*payload*/, void* /*data*/) override {
    return false;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<uint32_t>(static_cast<std::vector<uint8_t>*>(data)->size()); };
  }
  void* createData() override { return new std::vector<uint8_t>(); }
  void deleteData(void* data) override { delete static_cast<std::vector<uint8_t>*>(data); }
  bool getKey(void* /*data*/, eprosima::fastrtps::rtps::InstanceHandle_t* /*handle*/, bool /*md5*/) override {
    return false;
  }

  static constexpr uint32_t kMostBytes = 200'000;
};

/// Sends damaged copies of a valid message: other bytes, lengths of 4 GB, the other endianness, and shorter ones.
template <class Type>
void SendDamaged(const std::string& dds_topic, const typename Type::type& valid, int n) {
  Type type;
  eprosima::fastrtps::rtps::SerializedPayload_t payload(RawType::kMostBytes);
  auto message = valid;
  type.serialize(&message, &payload);
  auto* const participant =
      fast::DomainParticipantFactory::get_instance()->create_participant(0, fast::PARTICIPANT_QOS_DEFAULT);
  const fast::TypeSupport raw(new RawType(type.getName()));
  raw.register_type(participant);
  fast::DataWriterQos qos = fast::DATAWRITER_QOS_DEFAULT;
  qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  qos.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  auto* const writer =
      participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
          ->create_datawriter(participant->create_topic(dds_topic, type.getName(), fast::TOPIC_QOS_DEFAULT), qos);
  fast::PublicationMatchedStatus status;
  for (int i = 0; i < 500 && status.current_count == 0; ++i) {
    usleep(10'000);
    writer->get_publication_matched_status(status);
  }
  std::mt19937 random(11);
  for (int i = 0; i < n; ++i) {
    std::vector<uint8_t> bytes(payload.data, payload.data + payload.length);
    // Most of a message are pixels, which say nothing.
    const size_t n_head = std::min<size_t>(bytes.size(), 120);
    for (int k = 0; k < 1 + i % 4; ++k) bytes[4 + random() % (n_head - 4)] = static_cast<uint8_t>(random());
    const size_t word = 4 + 4 * (random() % (n_head / 4 - 1));
    if (i % 3 == 0) std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(word), 4, uint8_t{0xff});
    if (i % 7 == 0) bytes[1] = 0;
    if (i % 5 == 0) bytes.resize(4 + random() % (bytes.size() - 4));
    writer->write(&bytes);
    usleep(1000);
  }
}

void SendDamagedMessages(const plslam::RigCalibration& rig, const cv::Mat& grey, int n) {
  using namespace sensor_msgs::msg::dds_;
  SendDamaged<Image_PubSubType>("rt/stereo/left/image_raw", ImageOf(grey, 1'000'000), n);
  SendDamaged<CameraInfo_PubSubType>("rt/stereo/left/camera_info", InfoOf(rig.left, 0.0, 1'000'000), n);
  SendDamaged<nav_msgs::msg::dds_::Odometry_PubSubType>("rt/wheels", OdometryOf(plslam::SE3(), 1'000'000), n);
  SendDamaged<Imu_PubSubType>("rt/imu/data", ImuOf({}, 1'000'000), n);
  tf2_msgs::msg::dds_::TFMessage_ frames;
  frames.transforms().resize(2);
  SendDamaged<tf2_msgs::msg::dds_::TFMessage_PubSubType>("rt/tf_static", frames, n);
}

}  // namespace

int main(int argc, char** argv) {
  const auto dataset = plslam::OpenDataset(argv[1], "");
  const double rate_hz = std::atof(argv[2]);
  const int n_frames = std::min(std::atoi(argv[3]), dataset->size());
  std::set<std::string> options(argv + 4, argv + argc);
  double listen_s = 2.0;
  int n_hostile = 0;
  std::string space;
  int64_t begin_ns = 1'000'000'000;
  for (const std::string& option : options) {
    if (option.rfind("listen_s=", 0) == 0) listen_s = std::atof(option.c_str() + 9);
    if (option.rfind("space=", 0) == 0) space = option.substr(6);
    if (option.rfind("hostile=", 0) == 0) n_hostile = std::atoi(option.c_str() + 8);
    if (option.rfind("begin_s=", 0) == 0) begin_ns = std::atoll(option.c_str() + 8) * 1'000'000'000;
  }
  const auto has = [&](const char* option) { return options.count(option) > 0; };

  std::vector<plslam::StereoImages> ready;
  for (int i = 0; has("synchronous") && i < n_frames; ++i) ready.push_back(dataset->Read(i));

  Robot robot;
  robot.is_synchronous = has("synchronous");
  using Image = sensor_msgs::msg::dds_::Image_PubSubType;
  using Jpeg = sensor_msgs::msg::dds_::CompressedImage_PubSubType;
  using Info = sensor_msgs::msg::dds_::CameraInfo_PubSubType;
  fast::DataWriter* images[2] = {nullptr, nullptr};
  fast::DataWriter* infos[2] = {nullptr, nullptr};
  for (int i = 0; i < (has("no_right") ? 1 : 2); ++i) {
    const bool rgbd = dataset->rig().kind == plslam::RigCalibration::Kind::kRgbd;
    const std::string side = space + (rgbd ? (i == 0 ? "/camera/color" : "/camera/aligned_depth_to_color")
                                           : (i == 0 ? "/stereo/left" : "/stereo/right"));
    images[i] = has("jpeg") ? robot.Writer<Jpeg>(side + "/image_raw/compressed", has("reliable"))
                            : robot.Writer<Image>(side + "/image_raw", has("reliable"));
    if (!has("no_info")) infos[i] = robot.Writer<Info>(side + "/camera_info", true);
  }
  auto* const odometry = robot.Reader<nav_msgs::msg::dds_::Odometry_PubSubType>(space + "/plslam/odom", false);
  auto* const transforms = robot.Reader<tf2_msgs::msg::dds_::TFMessage_PubSubType>("/tf", false);
  auto* const points =
      robot.Reader<sensor_msgs::msg::dds_::PointCloud2_PubSubType>(space + "/plslam/map/points", true);
  auto* const path = robot.Reader<nav_msgs::msg::dds_::Path_PubSubType>(space + "/plslam/path", true);

  auto* const wheels =
      has("wheels") ? robot.Writer<nav_msgs::msg::dds_::Odometry_PubSubType>("/wheels", true) : nullptr;
  if (has("tf_static")) PublishMounting(robot, dataset->rig());
  std::unique_ptr<ImuDriver> imu;
  if (has("imu") || has("imu_apart")) {
    imu = std::make_unique<ImuDriver>(robot, dataset->ImuSamples(), has("imu_apart"));
  }

  json heard{{"sent", 0}, {"odom", json::array()}, {"tf", json::object()}, {"points", 0}, {"path", 0}};
  std::map<int64_t, double> sent_at, heard_at;
  std::vector<double> delays_ms;
  const auto begin = Clock::now();
  const auto now_s = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const auto listen = [&] {
    fast::SampleInfo info;
    nav_msgs::msg::dds_::Odometry_ odom;
    while (odometry->take_next_sample(&odom, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      const auto& p = odom.pose().pose().position();
      const auto& q = odom.pose().pose().orientation();
      heard["odom"].push_back(
          {StampOf(odom.header()), p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w(), odom.pose().covariance()[0]});
      heard["odom_frames"] = {odom.header().frame_id(), odom.child_frame_id()};
      const auto sent = sent_at.find(StampOf(odom.header()));
      if (sent != sent_at.end()) delays_ms.push_back(1e3 * (now_s() - sent->second));
    }
    tf2_msgs::msg::dds_::TFMessage_ tf;
    while (transforms->take_next_sample(&tf, &info) == ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      for (const auto& one : tf.transforms()) {
        const std::string name = one.header().frame_id() + " " + one.child_frame_id();
        heard["tf"][name] = heard["tf"].value(name, 0) + 1;
      }
    }
    sensor_msgs::msg::dds_::PointCloud2_ cloud;
    while (points->take_next_sample(&cloud, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) heard["points"] = cloud.width();
    }
    nav_msgs::msg::dds_::Path_ poses;
    while (path->take_next_sample(&poses, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) heard["path"] = poses.poses().size();
    }
  };

  // Discovery: a frame counts from when all topics have a subscriber.
  const auto matched = [&](fast::DataWriter* writer) {
    fast::PublicationMatchedStatus status;
    return writer == nullptr ||
           (writer->get_publication_matched_status(status) == ReturnCode_t::RETCODE_OK && status.current_count > 0);
  };
  while (now_s() < 10.0 && !(matched(images[0]) && matched(images[1]) && matched(infos[0]) && matched(infos[1]) &&
                             (!imu || imu->HasReaders()))) {
    usleep(20'000);
  }
  usleep(1'500'000);  // until they know it, too
  heard["discovery_s"] = now_s();
  const plslam::RigCalibration& rig = dataset->rig();
  if (n_hostile > 0) SendDamagedMessages(rig, dataset->Read(0).left, n_hostile);
  double due_s = now_s();
  for (int i = 0; i < n_frames; ++i) {
    const plslam::StereoImages frame = ready.empty() ? dataset->Read(i) : ready[static_cast<size_t>(i)];
    int64_t t_ns[2] = {dataset->t_ns(i) + begin_ns, dataset->t_ns(i) + begin_ns};
    if (has("other_clock")) t_ns[1] += 3600'000'000'000;
    if (has("unsynchronised")) t_ns[1] += 20'000'000;
    if (has("constant")) t_ns[0] = t_ns[1] = 7'000'000'000;
    while (now_s() < due_s) {
      listen();
      usleep(500);
    }
    due_s += 1.0 / rate_hz;
    if (imu) imu->PublishUntil(dataset->t_ns(i), begin_ns);
    if (wheels != nullptr) {
      auto wheel_odometry = OdometryOf(dataset->GroundTruth(0)->Inverse() * *dataset->GroundTruth(i), t_ns[0]);
      if (has("lies") && i % 10 == 0) wheel_odometry.pose().pose().position().x(NAN);
      wheels->write(&wheel_odometry);
    }
    for (int side = 0; side < 2; ++side) {
      if (images[side] == nullptr) continue;
      if (infos[side] != nullptr) {
        auto info = InfoOf(side == 0 ? rig.left : rig.right, side == 0 ? 0.0 : rig.baseline_m, t_ns[side]);
        infos[side]->write(&info);
      }
      cv::Mat pixels = side == 0 ? frame.left : frame.right;
      if (has("covered") && i >= kCoveredFrom && i < kCoveredTo)
        pixels = cv::Mat::zeros(pixels.size(), pixels.type());
      if (has("jpeg")) {
        auto image = JpegOf(pixels, t_ns[side]);
        images[side]->write(&image);
      } else {
        auto image = ImageOf(pixels, t_ns[side]);
        if (has("lies") && i % 2 == 0) image.height(i % 4 == 0 ? 4'000'000'000U : 10'000U);
        if (has("lies") && i % 6 == 1) image.encoding("unknown16");
        images[side]->write(&image);
      }
    }
    sent_at[t_ns[0]] = now_s();
    // Stamped by the clock that all processes of this machine share.
    heard["sent_at_s"].push_back({t_ns[0], std::chrono::duration<double>(Clock::now().time_since_epoch()).count()});
    heard["sent"] = i + 1;
  }
  for (const double end_s = now_s() + listen_s; now_s() < end_s; usleep(1000)) listen();
  std::sort(delays_ms.begin(), delays_ms.end());
  if (!delays_ms.empty()) heard["median_delay_ms"] = delays_ms[delays_ms.size() / 2];
  std::printf("%s\n", heard.dump().c_str());
  std::fflush(stdout);
  std::_Exit(0);  // destructors of Fast DDS wait for seconds
}
