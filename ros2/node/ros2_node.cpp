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

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/datasets/imu_topics.h"
#include "core/errors/error_text.h"
#include "core/errors/log.h"
#include "core/files/dataset_error.h"
#include "core/robot/image_topics.h"
#include "core/run/process_names.h"
#include "plslam/robot_motion_t.hpp"
#include "ros2/arguments.h"
#include "ros2/names.h"

namespace plslam::ros2 {
namespace {

constexpr double kNsPerMs = 1e6;
constexpr std::chrono::milliseconds kWait{100};
/// Time after which a missing input is reported: discovery takes two to three seconds.
constexpr double kPatience_s = 4.0;
/// Time in which /tf_static is awaited after the first CameraInfo, where it has a publisher: some repeat what late
/// subscribers lack every three seconds.
constexpr double kPatienceForFrames_s = 5.0;
/// Wheels may start later than cameras.
constexpr int64_t kFramesWithoutMotions = 20;

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
      progress_s_(bus::NowS()),
      run_(process.bus(),
           LiveMessages([this](const RosTopic& row, int64_t t_ns, const std::string& cdr) { Write(row, t_ns, cdr); },
                        FramesOf(options)),
           [] { return false; }),
      services_(process, domain_, options) {
  Ros2Options shown = options;
  process_.SetConfiguration(ToYaml("ros2", shown));
  for (const robot::Side side : {robot::Side::kLeft, robot::Side::kRight}) {
    const std::string& topic = side == robot::Side::kLeft ? options.left : options.right;
    Side& own = sides_[static_cast<size_t>(side)];
    own.input.topic = topic;
    own.input.type = ImageTypeOf(topic);
    own.reader =
        participant_.ReadImages(topic, robot::IsCompressedTopic(topic),
                                [this, side](robot::ForeignImage image) { TakeImage(side, std::move(image)); });
    // Depths have the camera of the colour image.
    if (!options.camera.empty() || (side == robot::Side::kRight && frames_.is_rgbd())) continue;
    const std::string& given = side == robot::Side::kLeft ? options.left_info : options.right_info;
    const std::string info = given.empty() ? robot::InfoTopicOf(topic) : given;
    const size_t reader = participant_.ReadInfos(info, [this, side](RosCameraInfo message, const std::string& frame) {
      TakeInfo(side, std::move(message), frame);
    });
    infos_.push_back({{info, "sensor_msgs/msg/CameraInfo", {}, {}, {}}, reader});
  }
  if (options.camera.empty()) {
    participant_.ReadStaticFrames([this](const std::string& parent, const std::string& child, const SE3& T) {
      static_frames_.Add(parent, child, T);
    });
  }
  if (!options.imu.empty()) ReadImu();
  if (!options.robot_odometry.empty()) {
    motions_ = participant_.ReadOdometry(options.robot_odometry,
                                         [this](int64_t t_ns, const SE3& T_robot_b) { TakeMotion(t_ns, T_robot_b); });
  }
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
  ReadStates();
  // A run ends with its source; a service that is restarted continues its stream.
  if (process_.has_launcher()) frames_.End();
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
  if (motions_ && topic == options_.robot_odometry) {
    process_.SetCounter("motions.rejected", static_cast<double>(++n_motions_rejected_));
  } else if (imu_topics_.contains(topic)) {
    process_.SetCounter("imu.rejected", static_cast<double>(++n_imu_rejected_));
  } else {
    process_.SetCounter("frames.rejected", static_cast<double>(++n_rejected_));
  }
  skipped_messages_.WarnOnce(fmt::format("a message on {} {}", topic, reason));
}

void Ros2Node::TakeImage(robot::Side side, robot::ForeignImage image) {
  Input& input = sides_[static_cast<size_t>(side)].input;
  input.previous_stamp_ns = std::exchange(input.stamp_ns, image.t_ns);
  pair_bytes_ = std::max(pair_bytes_, 2 * static_cast<int64_t>(image.bytes.size()));
  rates_[static_cast<size_t>(side)].Add(image.t_ns, bus::NowS());
  frames_.AddImage(side, std::move(image));
}

void Ros2Node::TakeInfo(robot::Side side, RosCameraInfo info, const std::string& frame) {
  if (side == robot::Side::kLeft) left_frame_ = frame;
  if (!held_infos_[0] && !held_infos_[1]) held_since_s_ = bus::NowS();
  held_infos_[static_cast<size_t>(side)] = std::move(info);
  UseInfos();
}

/// Returns whether the first rig waits for /tf_static, if there is a publisher of it: that of another plslam_ros2 knows
/// nothing of this camera.
bool Ros2Node::AwaitsFrames(bool knows_mounting) const {
  if (knows_mounting || frames_.has_rig() || bus::NowS() - held_since_s_ >= kPatienceForFrames_s) return false;
  const std::vector<Publisher> publishers = participant_.Publishers();
  return std::ranges::any_of(publishers, [](const Publisher& publisher) {
    return publisher.topic == ros_topic::kTfStatic.name && !publisher.is_ours;
  });
}

/// A rig that changed while it is in use would begin a new session, so /tf_static is awaited for a while.
void Ros2Node::UseInfos() {
  if (!held_infos_[0] || (!held_infos_[1] && !frames_.is_rgbd())) return;
  const std::optional<SE3> T_b_l = static_frames_.Find(options_.base_frame, left_frame_);
  const bool have_names = !left_frame_.empty() && !imu_frame_.empty();
  const std::optional<SE3> T_l_imu = have_names ? static_frames_.Between(left_frame_, imu_frame_) : std::nullopt;
  awaits_frames_ = AwaitsFrames(T_b_l && (T_l_imu || !frames_.imu().needs_mounting()));
  if (awaits_frames_) return;
  if (T_b_l) frames_.SetMounting(*T_b_l);
  if (T_l_imu && !frames_.has_rig()) frames_.imu().SetMounting(*T_l_imu);
  if (!frames_.has_rig()) {
    const std::string where = T_b_l ? "is on the body where /tf_static has it"
                                    : "looks along x of the body: /tf_static has no transform of it";
    LogInfo("the camera ({}) {}", Shown(left_frame_), where);
  }
  auto infos = std::exchange(held_infos_, {});
  frames_.AddInfo(robot::Side::kLeft, *std::move(infos[0]));
  if (infos[1]) frames_.AddInfo(robot::Side::kRight, *std::move(infos[1]));
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
  if (awaits_frames_) participant_.ReadStaticFramesAgain();
  ReportMotions();
  AnnounceNode();
  ReadStates();
  if (frames_.n_sent() > n_sent_) {
    NoteProgress();
    ReportRate();
  } else if (bus::NowS() - progress_s_ >= kPatience_s) {
    ReportLack();
  }
}

void Ros2Node::ReadStates() {
  for (Side& side : sides_) side.input.state = participant_.StateOf(side.reader);
  for (Side& info : infos_) info.input.state = participant_.StateOf(info.reader);
  // Both cameras have one rate; a side that misses many images does not show it.
  double sent_hz = 0.0;
  for (ImageRate& rate : rates_) sent_hz = std::max(sent_hz, rate.Of(bus::NowS()).sent_hz);
  if (sent_hz > 0.0) {
    for (ImageRate& rate : rates_) rate.CountMissing(sent_hz);
  }
  process_.SetCounter("images.lost", static_cast<double>(rates_[0].n_missing() + rates_[1].n_missing()));
}

void Ros2Node::NoteProgress() {
  n_sent_ = frames_.n_sent();
  progress_s_ = bus::NowS();
  n_rejected_before_ = n_rejected_;
  for (Side& side : sides_) side.n_before = side.input.state.n_messages;
}

void Ros2Node::ReadImu() {
  const ImuTopics topics = ImuTopicsOf(options_.imu);
  imu_topics_ = {topics.rates, topics.forces};
  for (const std::string& topic : imu_topics_) {
    const bool has_rate = topic == topics.rates, has_force = topic == topics.forces;
    participant_.ReadImu(
        topic, [this, has_rate, has_force](const RosImu& message) { TakeImu(message, has_rate, has_force); });
  }
}

/// `has_rate` and `has_force` are what the topic is for.
void Ros2Node::TakeImu(const RosImu& message, bool has_rate, bool has_force) {
  if ((has_rate && !message.has_rate) || (has_force && !message.has_force)) {
    throw DatasetError("has a covariance that begins with -1, and so nothing was measured");
  }
  if (has_rate && imu_frame_.empty()) imu_frame_ = message.frame;
  const ImuSample& sample = message.sample;
  if (has_rate && has_force) {
    frames_.imu().Add(sample);
  } else if (has_rate) {
    frames_.imu().AddRate(sample.t_ns, sample.rate_rad_s);
  } else {
    frames_.imu().AddForce(sample.t_ns, sample.force_m_s2);
  }
}

void Ros2Node::TakeMotion(int64_t t_ns, const SE3& T_robot_b) {
  robot_motion_t motion{};
  motion.header.t_ns = t_ns;
  motion.T_robot_b = bus::ToMessage(T_robot_b);
  process_.bus().Publish(bus::kRobotMotion, motion);
  ++n_motions_;
}

void Ros2Node::ReportMotions() {
  if (!motions_) return;
  process_.SetCounter("motions.sent", static_cast<double>(n_motions_));
  if (n_motions_ > 0 || frames_.n_sent() < kFramesWithoutMotions || std::exchange(warned_of_motions_, true)) return;
  process_.Warn(
      "robot_odometry_missing",
      fmt::format("no message arrives on {} (ros2.robot_odometry), so frames are tracked without the robot's "
                  "odometry: `plslam topics ros2:` lists the topics of nav_msgs/msg/Odometry",
                  Shown(options_.robot_odometry)));
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
  Symptoms symptoms{.domain = domain_.id,
                    .left = sides_[0].input,
                    .right = sides_[1].input,
                    .infos = {},
                    .publishers = participant_.Publishers(),
                    .has_rig = frames_.has_rig(),
                    .n_rejected = n_rejected_ - n_rejected_before_,
                    .max_skew_ms = options_.max_skew_ms};
  symptoms.left.state.n_messages -= sides_[0].n_before;
  symptoms.right.state.n_messages -= sides_[1].n_before;
  for (const Side& info : infos_) symptoms.infos.push_back(info.input);
  const std::string why = WhyNoFrames(symptoms);
  process_.SetReason(why);
  const std::string before = std::exchange(lack_, why);
  if (why == before) return;
  const std::string sentence = "no frames: " + why;
  // Before the first frame the robot may not be running yet; an outage has one warning, however its causes change.
  if (frames_.n_sent() > 0 && before.empty()) {
    process_.Warn("ros2_no_frames", sentence);
  } else {
    LogWarning("{}", sentence);
  }
}

void Ros2Node::ReportRate() {
  lack_.clear();
  // The worse side, at the rate of the better one: both cameras have one rate.
  const std::array<ImageRate::Rates, 2> of_side{rates_[0].Of(bus::NowS()), rates_[1].Of(bus::NowS())};
  const size_t worse = of_side[1].arrived_hz > 0.0 && of_side[1].arrived_hz < of_side[0].arrived_hz ? 1 : 0;
  const ImageRate::Rates rates{.sent_hz = std::max(of_side[0].sent_hz, of_side[1].sent_hz),
                               .arrived_hz = of_side[worse].arrived_hz};
  process_.SetCounter("images.rate_hz", rates.arrived_hz);
  process_.SetCounter("images.sent_hz", rates.sent_hz);
  const std::string sentence = LossSentence(rates, pair_bytes_, LargestReceiveBuffer());
  process_.SetReason(sentence);
  if (sentence.empty() || std::exchange(warned_of_loss_, true)) return;
  process_.Warn("ros2_images_lost", (worse == 0 ? options_.left : options_.right) + ": " + sentence);
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
