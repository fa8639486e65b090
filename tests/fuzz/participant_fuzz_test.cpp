// SPDX-License-Identifier: BSD-3-Clause
// Mutates what a robot of ROS 2 sends, as DDS receives it: samples are rejected with a sentence, or are consistent,
// within a bound of memory. The writer is in this process, so the bytes take the way of received ones without a network.
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include <ros_types.h>
#include "core/files/dataset_error.h"
#include "core/io/images/jpeg_codec.h"
#include "core/robot/foreign_image.h"
#include "ros2/dds/participant.h"
#include "ros2/names.h"
#include "tests/fuzz/message_mutator.h"
#include "tests/support/fuzzing.h"
#include "tests/unit/bus/allocation_counter.h"

namespace plslam::ros2 {
namespace {

using Bytes = std::vector<uint8_t>;

constexpr int kWidth = 32, kHeight = 16;
const cv::Size kSize(kWidth, kHeight);

/// A writer of bytes, of the type of a topic.
class RawWriter {
 public:
  template <class Sample>
  RawWriter(dds_entity_t participant, const std::string& topic, const dds_topic_descriptor_t& type, Sample valid) {
    const dds_entity_t entity = dds_create_topic(participant, &type, DdsTopicName(topic).c_str(), nullptr, nullptr);
    std::unique_ptr<dds_qos_t, decltype(&dds_delete_qos)> qos(dds_create_qos(), dds_delete_qos);
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, DDS_MSECS(100));
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    writer_ = dds_create_writer(participant, entity, qos.get(), nullptr);
    // The bytes of a valid sample, and the internal type of the topic, by a reader of its own.
    const dds_entity_t reader = dds_create_reader(participant, entity, qos.get(), nullptr);
    EXPECT_EQ(dds_write(writer_, &valid), DDS_RETCODE_OK) << topic;
    ddsi_serdata* written = nullptr;
    dds_sample_info_t info;
    EXPECT_EQ(dds_takecdr(reader, &written, 1, &info, DDS_ANY_STATE), 1) << topic;
    type_ = written->type;
    valid_.resize(ddsi_serdata_size(written));
    ddsi_serdata_to_ser(written, 0, valid_.size(), valid_.data());
    ddsi_serdata_unref(written);
    dds_delete(reader);
  }

  const Bytes& valid() const { return valid_; }
  /// Returns whether DDS itself accepts them.
  bool Write(Bytes bytes) const {
    ddsrt_iovec_t part{};
    part.iov_base = bytes.data();
    part.iov_len = bytes.size();
    ddsi_serdata* const sample = ddsi_serdata_from_ser_iov(type_, SDK_DATA, 1, &part, bytes.size());
    if (sample == nullptr) return false;
    EXPECT_EQ(dds_writecdr(writer_, sample), DDS_RETCODE_OK);
    return true;
  }

 private:
  dds_entity_t writer_ = 0;
  const ddsi_sertype* type_ = nullptr;
  Bytes valid_;
};

/// A sequence in a sample that is written once, of bytes that live elsewhere.
template <class Sequence, class Element>
void Lend(std::vector<Element>& elements, Sequence* sequence) {
  sequence->_buffer = elements.data();
  sequence->_length = sequence->_maximum = static_cast<uint32_t>(elements.size());
}

class ParticipantFuzz : public testing::Test {
 protected:
  ParticipantFuzz() : domain_{.id = 100 + static_cast<int>(getpid() % 100), .loopback_only = true} {
    participant_ = std::make_unique<Participant>(domain_, CycloneConfiguration(domain_, ""));
    participant_->ReadImages("/image", false, [this](robot::ForeignImage image) { TakeImage(image); });
    participant_->ReadImages("/compressed", true, [this](robot::ForeignImage image) { TakeImage(image); });
    participant_->ReadInfos("/info", [this](const RosCameraInfo& info, const std::string&) {
      RigFromRos(InPixelsOfImages(info, {}), InPixelsOfImages(info, {}), false);
      ++n_taken_;
    });
    participant_->ReadStaticFrames([this](const std::string&, const std::string&, const SE3& T) { TakePose(T); });
    participant_->ReadImu("/imu", [this](const RosImu& imu) {
      EXPECT_TRUE(imu.sample.rate_rad_s.allFinite() && imu.sample.force_m_s2.allFinite());
      EXPECT_GE(imu.sample.t_ns, 0);
      ++n_taken_;
    });
    participant_->ReadOdometry("/odom", [this](int64_t t_ns, const SE3& T) {
      EXPECT_GE(t_ns, 0);
      TakePose(T);
    });
    AddWriters();
  }

  void AddWriters() {
    // In the domain that the participant has opened.
    const dds_entity_t robot = dds_create_participant(static_cast<dds_domainid_t>(domain_.id), nullptr, nullptr);
    std_msgs_msg_dds__Header_ header{};
    header.stamp.sec = 7;
    header.frame_id = frame_.data();
    Bytes pixels(size_t{kWidth} * kHeight, 7);
    sensor_msgs_msg_dds__Image_ image{};
    image.header = header;
    image.width = image.step = kWidth;
    image.height = kHeight;
    image.encoding = encoding_.data();
    Lend(pixels, &image.data);
    writers_.emplace_back(robot, "/image", sensor_msgs_msg_dds__Image__desc, image);

    const std::string jpeg = EncodeJpeg(cv::Mat(kSize, CV_8UC1, cv::Scalar(90)), 80);
    Bytes file(jpeg.begin(), jpeg.end());
    sensor_msgs_msg_dds__CompressedImage_ compressed{};
    compressed.header = header;
    compressed.format = format_.data();
    Lend(file, &compressed.data);
    writers_.emplace_back(robot, "/compressed", sensor_msgs_msg_dds__CompressedImage__desc, compressed);

    std::vector<double> distortion(5);
    sensor_msgs_msg_dds__CameraInfo_ info{};
    info.header = header;
    info.width = kWidth;
    info.height = kHeight;
    info.distortion_model = model_.data();
    Lend(distortion, &info.d);
    for (const int i : {0, 4, 8}) info.k[i] = info.r[i] = 1.0;
    for (const int i : {0, 5, 10}) info.p[i] = 1.0;
    writers_.emplace_back(robot, "/info", sensor_msgs_msg_dds__CameraInfo__desc, info);

    std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms(2);
    for (auto& transform : transforms) {
      transform.header = header;
      transform.child_frame_id = frame_.data();
      transform.transform.rotation.w = 1.0;
    }
    tf2_msgs_msg_dds__TFMessage_ frames{};
    Lend(transforms, &frames.transforms);
    writers_.emplace_back(robot, "/tf_static", tf2_msgs_msg_dds__TFMessage__desc, frames);

    sensor_msgs_msg_dds__Imu_ imu{};
    imu.header = header;
    imu.orientation.w = 1.0;
    writers_.emplace_back(robot, "/imu", sensor_msgs_msg_dds__Imu__desc, imu);

    nav_msgs_msg_dds__Odometry_ odometry{};
    odometry.header = header;
    odometry.child_frame_id = frame_.data();
    odometry.pose.pose.orientation.w = 1.0;
    writers_.emplace_back(robot, "/odom", nav_msgs_msg_dds__Odometry__desc, odometry);
  }

  void TakePose(const SE3& T) {
    EXPECT_TRUE(T.IsFinite());
    EXPECT_NEAR(T.rotation().norm(), 1.0, 1e-9);
    ++n_taken_;
  }
  void TakeImage(const robot::ForeignImage& image) {
    constexpr int kWhite = 65535;
    EXPECT_GE(image.t_ns, 0);
    EXPECT_EQ(robot::GreyOf(image, kSize, kWhite).size(), kSize);
    ++n_taken_;
  }
  /// Hands over what has been written. Returns the number of samples that were used.
  int Receive() {
    n_taken_ = 0;
    participant_->Receive(std::chrono::milliseconds(0), [](const std::string& topic, const std::string& reason) {
      EXPECT_NE(topic, "");
      EXPECT_NE(reason, "");
    });
    return n_taken_;
  }

  std::string frame_ = "camera", encoding_ = "mono8", format_ = "mono8; jpeg compressed ", model_ = "plumb_bob";
  const Domain domain_;
  std::unique_ptr<Participant> participant_;
  std::vector<RawWriter> writers_;
  int n_taken_ = 0;
};

TEST_F(ParticipantFuzz, SamplesAreRefusedOrWhole) {
  Receive();
  const test::FuzzCounts counts = test::Fuzz([&](std::mt19937_64& random) {
    const RawWriter& writer = writers_[random() % writers_.size()];
    Bytes bytes = writer.valid();
    test::Mutate(bytes, random);
    if (random() % 16 == 0) bytes[1] ^= 1U;  // the other order of bytes
    if (!writer.Write(bytes)) return false;
    bus::test::allocated = 0;
    const bool is_taken = Receive() > 0;
    EXPECT_LE(bus::test::allocated, 64 * bytes.size() + 100'000);
    return is_taken;
  });
  EXPECT_GT(counts.accepted, counts.cases / 20);
  EXPECT_LT(counts.accepted, counts.cases - counts.cases / 20);
}

}  // namespace
}  // namespace plslam::ros2
