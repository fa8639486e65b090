// SPDX-License-Identifier: BSD-3-Clause
#include "ros2/node/ros2_node.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include "core/bus/run_loop.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/robot/image_topics.h"
#include "core/run/process_names.h"
#include "ros2/arguments.h"
#include "ros2/names.h"

namespace plslam::ros2 {
namespace {

constexpr double kNsPerMs = 1e6;
constexpr std::chrono::milliseconds kWait{100};
/// Reports in a row of lost images after which there is a warning: rates of two sides may change one after the other.
constexpr int kLossyReports = 2;

std::string Environment(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

Domain DomainOfEnvironment() {
  return DomainOf([](const char* name) { return std::getenv(name); });
}

/// Returns the receive buffer that the kernel grants if 16 MB are requested, as Cyclone DDS does.
int64_t LargestReceiveBuffer() {
  const int descriptor = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (descriptor < 0) return 0;
  int bytes = 16 << 20;
  socklen_t n = sizeof(bytes);
  setsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &bytes, n);
  getsockopt(descriptor, SOL_SOCKET, SO_RCVBUF, &bytes, &n);
  close(descriptor);
  return bytes / 2;  // the kernel reports twice what is for data
}

RobotFrames FramesOf(const Ros2Options& options) {
  return {.map = options.map_frame,
          .odom = options.odom_frame,
          .body = options.base_frame,
          .camera = CameraFrameOf(options.base_frame, options.camera_frame),
          .writes_map = options.publish_tf == PublishedTf::kAll || options.publish_tf == PublishedTf::kMap,
          .writes_odom = options.publish_tf == PublishedTf::kAll || options.publish_tf == PublishedTf::kOdom,
          .writes_camera = options.publish_tf != PublishedTf::kNone};
}

const char* ImageTypeOf(const std::string& topic) {
  return robot::IsCompressedTopic(topic) ? "sensor_msgs/msg/CompressedImage" : "sensor_msgs/msg/Image";
}

}  // namespace

Ros2Node::Ros2Node(bus::Process& process, const Ros2Options& options)
    : process_(process),
      options_(options),
      domain_(DomainOfEnvironment()),
      participant_(domain_, CycloneConfiguration(domain_, Environment("CYCLONEDDS_URI"))),
      frames_(process,
              {.process = process_name::kRos2,
               .camera_option = "ros2.camera",
               .camera = options.camera,
               .left = options.left,
               .right = options.right,
               .max_skew_ns = std::llround(options.max_skew_ms * kNsPerMs),
               .imu = {.name = options.imu,
                       .option = "ros2.imu",
                       .calibration = options.imu_calibration,
                       .camera = options.camera}},
              {.on_rig = [](const RigCalibration&) {},
               .on_frame = [this](int64_t t_ns) { first_t_ns_ = std::min(first_t_ns_.load(), t_ns); }}),
      inputs_(bus::NowS()),
      held_infos_(options.base_frame),
      imu_(process, options.imu),
      odometry_(process, options.robot_odometry),
      run_(process.bus(),
           LiveMessages([this](const RosTopic& row, int64_t t_ns, const std::string& cdr) { Write(row, t_ns, cdr); },
                        FramesOf(options)),
           [] { return false; }),
      services_(process, domain_, options) {
  Ros2Options shown = options;
  process_.SetConfiguration(ToYaml("ros2", shown));
  for (const robot::Side side : {robot::Side::kLeft, robot::Side::kRight}) ReadImages(side);
  if (options.camera.empty()) {
    participant_.ReadStaticFrames([this](const std::string& parent, const std::string& child, const SE3& T) {
      held_infos_.AddFrame(parent, child, T);
    });
  }
  imu_.ReadFrom(participant_, frames_.imu());
  odometry_.ReadFrom(participant_);
  const std::string small_buffer = SmallBufferSentence(LargestReceiveBuffer());
  if (!small_buffer.empty() && !robot::IsCompressedTopic(options.left)) LogWarning("{}", small_buffer);
  if (!OffersOrders(process.bus().options(), domain_)) {
    LogInfo(
        "services are not offered: the bus has a key (bus.key_file), and DDS no proof of it; ROS_LOCALHOST_ONLY=1 "
        "offers them on this machine");
  }
  listener_ = std::thread([this] { bus::RunGuarded(process_.bus(), [this] { Listen(); }); });
}

Ros2Node::~Ros2Node() {
  stopped_ = true;
  listener_.join();
  ReadStates(true);
  // A run ends with its source; a service that is restarted continues its stream.
  if (process_.has_launcher()) frames_.End();
}

/// Reads the images of a side, and CameraInfo if there is no camera file.
void Ros2Node::ReadImages(robot::Side side) {
  const bool is_left = side == robot::Side::kLeft;
  const std::string& topic = is_left ? options_.left : options_.right;
  inputs_.SetImages(
      side, topic, ImageTypeOf(topic),
      participant_.ReadImages(topic, robot::IsCompressedTopic(topic),
                              [this, side](robot::ForeignImage image) { TakeImage(side, std::move(image)); }));
  // Depths have the camera of the colour image.
  if (!options_.camera.empty() || (!is_left && frames_.is_rgbd())) return;
  const std::string& given = is_left ? options_.left_info : options_.right_info;
  const std::string info = given.empty() ? robot::InfoTopicOf(topic) : given;
  inputs_.AddInfo(info, participant_.ReadInfos(info, [this, side](RosCameraInfo message, const std::string& frame) {
    TakeInfo(side, std::move(message), frame);
  }));
}

void Ros2Node::Listen() {
  double due_s = bus::NowS();
  while (!stopped_) {
    if (bus::NowS() >= due_s) {
      Tick();
      due_s = bus::NowS() + 1.0;
    }
    participant_.Receive(frames_.Wait(kWait),
                         [this](const std::string& topic, const std::string& reason) { Reject(topic, reason); });
    frames_.SendDue();
    services_.node().SendAnswers();
  }
}

void Ros2Node::Reject(const std::string& topic, const std::string& reason) {
  if (odometry_.Reads(topic)) {
    odometry_.CountRejected();
  } else if (imu_.Reads(topic)) {
    imu_.CountRejected();
  } else if (topic != ros_topic::kTfStatic.name) {
    process_.SetCounter("frames.rejected", static_cast<double>(inputs_.OnRejected()));
  }
  skipped_messages_.WarnOnce(fmt::format("a message on {} {}", topic, reason));
}

void Ros2Node::TakeImage(robot::Side side, robot::ForeignImage image) {
  inputs_.OnImage(side, image.t_ns);
  rates_.Add(side, image.t_ns, image.bytes.size(), bus::NowS());
  frames_.AddImage(side, std::move(image));
}

void Ros2Node::TakeInfo(robot::Side side, RosCameraInfo info, const std::string& frame) {
  held_infos_.Add(side, std::move(info), frame, bus::NowS());
  UseInfos();
}

/// Another plslam_ros2 publishes /tf_static, too, but knows nothing of this camera.
bool Ros2Node::OthersPublishFrames() const {
  const std::vector<Publisher> publishers = participant_.Publishers();
  return std::ranges::any_of(publishers, [](const Publisher& publisher) {
    return publisher.topic == ros_topic::kTfStatic.name && !publisher.is_ours;
  });
}

/// Logs where the camera is, at first and when /tf_static has it later.
void Ros2Node::LogMounting(bool is_mounted) {
  if (frames_.has_rig() && (is_mounted_ || !is_mounted)) return;
  is_mounted_ = is_mounted;
  const std::string frame = Shown(held_infos_.left_frame());
  if (is_mounted) return LogInfo("the camera ({}) is on the body where /tf_static has it", frame);
  const std::string sentence =
      fmt::format("the camera ({}) looks along x of the body: /tf_static has no transform of it from {}", frame,
                  Shown(options_.base_frame));
  OthersPublishFrames() ? LogWarning("{}", sentence) : LogInfo("{}", sentence);
}

void Ros2Node::UseInfos() {
  std::optional<HeldInfos::Ready> ready = held_infos_.Take({.is_rgbd = frames_.is_rgbd(),
                                                            .is_known = frames_.has_rig(),
                                                            .imu_frame = imu_.frame(),
                                                            .needs_imu_pose = frames_.imu().needs_mounting()},
                                                           bus::NowS(), [this] { return OthersPublishFrames(); });
  if (!ready) return;
  if (ready->T_b_l) frames_.SetMounting(*ready->T_b_l);
  if (ready->T_l_imu) frames_.imu().SetMounting(*ready->T_l_imu);
  LogMounting(ready->T_b_l.has_value());
  frames_.AddInfo(robot::Side::kLeft, std::move(ready->left));
  if (ready->right) frames_.AddInfo(robot::Side::kRight, *std::move(ready->right));
}

void Ros2Node::Write(const RosTopic& row, int64_t t_ns, const std::string& cdr) {
  // Poses of before are history, which the bus repeats to processes that start.
  const bool is_of_frame = row.rate == RosRate::kFrame;
  if (is_of_frame && t_ns < first_t_ns_) return;
  const bool is_tf = row.name == ros_topic::kTf.name || row.name == ros_topic::kTfStatic.name;
  const std::string topic =
      is_tf ? std::string(row.name) : InNamespace(options_.output_namespace, row.name.substr(1));
  participant_.Write(row, topic, cdr);
}

void Ros2Node::Tick() {
  frames_.PublishRig();
  if (held_infos_.awaits_frames()) participant_.ReadStaticFramesAgain();
  odometry_.Report(frames_.n_sent());
  AnnounceNode();
  ReadStates();
  const bool was_late = inputs_.has_reason();
  if (inputs_.HasProgress(frames_.n_sent(), bus::NowS())) {
    if (was_late) LogInfo("frames arrive");
    ReportRate();
  } else if (inputs_.AreLate(bus::NowS())) {
    ReportLack();
  }
}

void Ros2Node::ReadStates(bool is_last) {
  inputs_.ReadStates([this](size_t reader) { return participant_.StateOf(reader); });
  process_.SetCounter("images.lost", static_cast<double>(rates_.CountMissing(bus::NowS(), is_last)));
}

void Ros2Node::AnnounceNode() {
  const std::optional<size_t> gid_bytes = participant_.GidBytes(services_.node().id());
  if (!gid_bytes) return;
  const std::string& space = options_.output_namespace;
  services_.node().Announce({.participant = {},
                             .space = space.empty() ? "/" : space,
                             .name = "plslam_ros2",
                             .readers = participant_.Readers(),
                             .writers = participant_.Writers()},
                            *gid_bytes);
}

/// States why there have been no frames since the last progress.
void Ros2Node::ReportLack() {
  Symptoms symptoms = inputs_.SinceProgress();
  symptoms.domain = domain_.id;
  symptoms.publishers = participant_.Publishers();
  symptoms.has_rig = frames_.has_rig();
  symptoms.max_skew_ms = options_.max_skew_ms;
  const std::string why = WhyNoFrames(symptoms);
  process_.SetReason(why);
  const std::string before = inputs_.SetReason(why);
  if (why == before) return;
  const std::string sentence = "no frames: " + why;
  // Before the first frame the robot may not be running yet; an outage has one warning, however its causes change.
  const bool is_outage = frames_.n_sent() > 0 && before.empty();
  if (is_outage) process_.SetCounter("frames.outages", static_cast<double>(++n_outages_));
  if (!is_outage || !process_.Warn("ros2_no_frames", sentence)) LogWarning("{}", sentence);
}

void Ros2Node::ReportRate() {
  const PairRates::Worse worse = rates_.OfWorseSide(bus::NowS());
  process_.SetCounter("images.rate_hz", worse.rates.arrived_hz);
  process_.SetCounter("images.sent_hz", worse.rates.sent_hz);
  const std::string sentence = LossSentence(worse.rates, rates_.pair_bytes(), LargestReceiveBuffer());
  n_lossy_reports_ = sentence.empty() ? 0 : n_lossy_reports_ + 1;
  const bool is_lossy = n_lossy_reports_ >= kLossyReports;
  process_.SetReason(is_lossy ? sentence : "");
  if (!is_lossy || std::exchange(warned_of_loss_, true)) return;
  const std::string& topic = worse.side == robot::Side::kLeft ? options_.left : options_.right;
  process_.Warn("ros2_images_lost", topic + ": " + sentence);
}

bus::ProcessSpec Ros2Spec() {
  const auto line = std::make_shared<Arguments>();
  bus::ProcessSpec spec;
  spec.name = process_name::kRos2;
  spec.description =
      "Connects a robot that uses ROS 2, of any release, without anything of ROS installed: receives its stereo "
      "images "
      "through DDS, publishes poses, transforms and the map.";
  spec.examples =
      "  plslam_ros2 --left /stereo/left/image_raw --right /stereo/right/image_raw\n"
      "  ROS_DOMAIN_ID=7 plslam_ros2 --left /left/compressed --right /right/compressed --camera camera.yaml";
  spec.add_options = [line](CLI::App* app) { line->AddTo(app); };
  spec.make_node = [line](bus::Process& process, const Config& config) {
    Ros2Options options;
    config.Read("ros2", options);
    line->Apply(&options);
    return std::make_shared<Ros2Node>(process, options);
  };
  spec.waits_for = "images";
  spec.results = {{"frames.sent", "frames"},
                  {"frames.unpaired", "unpaired"},
                  {"frames.rejected", "rejected"},
                  {"images.lost", "images lost"}};
  return spec;
}

}  // namespace plslam::ros2
