// SPDX-License-Identifier: BSD-3-Clause
// vo_process with stand-ins for the other processes, on real buses over loopback.
#include "vo_process/node/vo_node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <vector>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/imu_channel.h"
#include "core/bus/messages/loop_channel.h"
#include "core/datasets/open_dataset.h"
#include "core/geometry/body_frame.h"
#include "core/process/process_status.h"
#include "core/run/run_counters.h"
#include "plslam/camera_t.hpp"
#include "plslam/mask_t.hpp"
#include "plslam/robot_motion_t.hpp"
#include "plslam/status_t.hpp"
#include "tests/support/slam_run.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::vo {
namespace {

using bus::test::RunningBus;

constexpr int64_t kFrame_ns = 50'000'000;
constexpr int8_t kLost = static_cast<int8_t>(TrackingState::kLost);

class VoNodeTest : public testing::Test {
 protected:
  VoNodeTest() : VoNodeTest("") {}
  /// With more options of the world.
  explicit VoNodeTest(const std::string& more)
      : dataset_(OpenDataset("synthetic:room?size=376x240&speed=2&frames=75" + more, "")) {
    bus_options_.url = bus::test::PrivateUrl();
    others_ = std::make_unique<RunningBus>(bus_options_, "others");
  }
  ~VoNodeTest() override {
    if (process_) process_->bus().Stop();
    if (vo_.joinable()) vo_.join();
    others_->Join();
  }

  void Start(const VoOptions& options, bool lockstep) {
    localise_only_ = options.map.localise_only;
    frames_ = std::make_unique<bus::FramePublisher>(**others_, lockstep);
    (*others_)->Subscribe<pose_t>(bus::kPose, [this](const pose_t& pose) { Keep([&] { pose_ = pose; }); });
    (*others_)->Subscribe<status_t>(bus::kStatus, [this](const status_t& status) {
      if (status.process == "vo") Keep([&] { status_ = status; });
    });
    questions_ = std::make_unique<bus::KeyframeSubscriber>(
        **others_, [this](const Keyframe& frame) { Keep([&] { asked_ = frame; }); }, bus::kRelocalisationRequest);
    (*others_)->Every(std::chrono::milliseconds(100),
                      [this] { (*others_)->Publish(bus::kCamera, bus::ToMessage(dataset_->rig())); });
    others_->Start();
    process_ = std::make_unique<bus::Process>("vo", bus_options_);
    node_ = std::make_unique<VoNode>(*process_, options);
    vo_ = std::thread([this] { process_->bus().Run(); });
  }
  void PublishMap(const Map& map) {
    maps_ = std::make_unique<bus::MapUpdatePublisher>(**others_, [] {});
    MapUpdate update = WholeMap(map);
    update.version = 1;
    update.localise_only = localise_only_;
    maps_->Publish(update);
  }

  void PublishUpdate(const MapUpdate& update) { maps_->Publish(update); }

  /// The next frame of the stream, and its pose.
  pose_t Show(int index, int64_t t_ns, bool covered = false) {
    StereoImages images = dataset_->Read(index);
    images.frame_id = FrameId(shown_.size());
    images.t_ns = t_ns;
    if (covered) images.left.setTo(0), images.right.setTo(0);
    if (exchanged_) std::swap(images.left, images.right);
    shown_.push_back(index);
    frames_->Publish(images);
    std::unique_lock lock(mutex_);
    const auto limit = plslam::test::Patience(std::chrono::seconds(20));
    EXPECT_TRUE(changed_.wait_for(lock, limit, [&] { return pose_ && FrameId(pose_->frame_id) == images.frame_id; }));
    return pose_.value_or(pose_t());
  }
  pose_t ShowNext(int index, bool covered = false) {
    return Show(index, kFrame_ns * static_cast<int64_t>(shown_.size() + 1), covered);
  }

  /// In a map that began at frame 0 of the dataset.
  SE3 Truth(int index) const { return dataset_->GroundTruth(0)->Inverse() * *dataset_->GroundTruth(index); }

  /// Publishes the result of loop_process for the newest request.
  void Answer(const Map& map) {
    Relocalisation answer;
    {
      const std::lock_guard lock(mutex_);
      if (!asked_) return;
      answer.session = asked_->name.session;
      answer.frame_id = asked_->frame_id;
    }
    const int index = shown_.at(static_cast<size_t>(answer.frame_id.value));
    answer.found = true;
    answer.T_w_c = Truth(index);
    answer.covariance = 1e-6 * Matrix6d::Identity();
    for (const auto& [id, keyframe] : map.keyframes()) {
      if (keyframe.frame_id <= index) answer.keyframe_id = id;
    }
    (*others_)->Publish(bus::kRelocalisation, bus::ToMessage(answer));
  }
  double ErrorInMap(const pose_t& pose) const {
    const SE3 T_w_c = *bus::FromMessage(pose.T_w_odom) * *bus::FromMessage(pose.T_odom_c);
    return (T_w_c.translation() - Truth(shown_.back()).translation()).norm();
  }
  void SayMask(int64_t frame_id, const FrameMask& mask) {
    mask_t message = bus::ToMessage(mask);
    message.frame_id = frame_id;
    message.header.t_ns = kFrame_ns * (frame_id + 1);
    (*others_)->Publish(bus::kMask, message);
  }
  /// Publishes wheel odometry of 0.97 of each step, twice a frame.
  void SayWheels(int index, int64_t frame_id) {
    const SE3 T_b_c = BodyFromCamera(dataset_->rig());
    for (int half = index > 0 ? 2 * index - 1 : 0; half <= 2 * index; ++half) {
      const auto at = [&](int h) {
        const SE3 T_w_c = *dataset_->GroundTruth(h / 2);
        const SE3 next = T_w_c.Inverse() * *dataset_->GroundTruth((h + 1) / 2);
        return T_w_c * SE3::Exp(0.5 * next.Log());
      };
      if (half > 0) {
        const SE3 T_prevb_b = T_b_c * at(half - 1).Inverse() * at(half) * T_b_c.Inverse();
        T_robot_b_ = T_robot_b_ * SE3::Exp(0.97 * T_prevb_b.Log());
      }
      robot_motion_t message{};
      message.header.t_ns = kFrame_ns * (frame_id + 1) - (2 * index - half) * kFrame_ns / 2;
      message.T_robot_b = bus::ToMessage(T_robot_b_);
      (*others_)->Publish(bus::kRobotMotion, message);
    }
  }
  /// Error of the last pose of 40 frames, the camera being covered for the last 20.
  double ErrorAfterTheDark_m(bool wheels) {
    pose_t pose;
    for (int i = 0; i < 40; ++i) {
      if (wheels) SayWheels(i, i);
      pose = ShowNext(i, i >= 20);
      EXPECT_EQ(pose.state == kLost, i >= 20) << i;
    }
    return (bus::FromMessage(pose.T_odom_c)->translation() - Truth(39).translation()).norm();
  }
  /// Publishes the samples of the inertial sensor between a frame and the one before.
  void SayImu(int index) {
    const int64_t shift_ns = kFrame_ns - dataset_->t_ns(0);
    const int64_t from_ns = dataset_->t_ns(std::max(index - 1, 0)), t_ns = dataset_->t_ns(index);
    const auto motion = SamplesOfMotion(dataset_->ImuSamples(), from_ns, t_ns);
    std::vector<ImuSample> samples(motion.begin(), motion.end());
    for (ImuSample& sample : samples) sample.t_ns += shift_ns;
    bus::PublishImu(**others_, from_ns + shift_ns, t_ns + shift_ns, samples);
  }
  bool HasPose(int64_t frame_id, std::chrono::milliseconds limit) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, limit, [&] { return pose_ && pose_->frame_id == frame_id; });
  }
  bool HasAsked() {
    const std::lock_guard lock(mutex_);
    return asked_.has_value();
  }

  void ForgetQuestion() {
    const std::lock_guard lock(mutex_);
    asked_.reset();
  }
  /// Starts a loop_process that publishes its status.
  std::unique_ptr<RunningBus> StartLoopProcess() {
    auto loop = std::make_unique<RunningBus>(bus_options_, "loop");
    (*loop)->Every(std::chrono::milliseconds(50), [loop = &**loop] {
      status_t status{};
      status.process = "loop";
      loop->Publish(bus::kStatus, status);
    });
    loop->Start();
    return loop;
  }

  const std::unique_ptr<Dataset> dataset_;
  std::vector<int> shown_;
  SE3 T_robot_b_;
  /// Left and right images are exchanged.
  bool exchanged_ = false;
  bool localise_only_ = false;  ///< as published with the map

  /// Waits until the tracker publishes a status for which `what` holds.
  bool Says(const std::function<bool(const status_t&)>& what) {
    std::unique_lock lock(mutex_);
    const auto limit = plslam::test::Patience(std::chrono::seconds(20));
    return changed_.wait_for(lock, limit, [&] { return status_ && what(*status_); });
  }

  bus::BusOptions bus_options_;

 private:
  template <class F>
  void Keep(F f) {
    const std::lock_guard lock(mutex_);
    f();
    changed_.notify_all();
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<pose_t> pose_;
  std::optional<status_t> status_;
  std::optional<Keyframe> asked_;
  std::unique_ptr<RunningBus> others_;
  std::unique_ptr<bus::FramePublisher> frames_;
  std::unique_ptr<bus::KeyframeSubscriber> questions_;
  std::unique_ptr<bus::MapUpdatePublisher> maps_;
  std::unique_ptr<bus::Process> process_;
  std::unique_ptr<VoNode> node_;
  std::thread vo_;
};

TEST_F(VoNodeTest, SmallClockStepLosesOnlyOneFrame) {
  VoOptions options;
  options.map.enabled = false;
  Start(options, true);
  constexpr int64_t kBegin_ns = 10'000'000'000;
  int64_t session = 0;
  for (int i = 0; i < 5; ++i) session = Show(i, kBegin_ns + kFrame_ns * i).header.session;
  for (const int64_t back_ns : {int64_t{1}, kFrame_ns / 2}) {
    const pose_t early = Show(5, kBegin_ns + 4 * kFrame_ns - back_ns);
    EXPECT_EQ(early.header.session, session);
    EXPECT_EQ(early.state, kLost);
    EXPECT_EQ(early.n_points, 0);
  }
  const pose_t next = Show(6, kBegin_ns + 6 * kFrame_ns);
  EXPECT_EQ(next.header.session, session);
  EXPECT_NE(next.state, kLost);
  const SE3 truth = dataset_->GroundTruth(0)->Inverse() * *dataset_->GroundTruth(6);
  EXPECT_LT((bus::FromMessage(next.T_odom_c)->translation() - truth.translation()).norm(), 0.02);
  EXPECT_NE(Show(7, kBegin_ns - 2'000'000'000).header.session, session) << "that is another stream";
}

TEST_F(VoNodeTest, RigOfAnIdlePlayerIsNotUsed) {
  VoOptions options;
  options.map.enabled = false;
  bus::Bus idle(bus_options_, "player");
  RigCalibration other = dataset_->rig();
  other.left.fx_px = other.right.fx_px = 1.1 * other.left.fx_px;
  Start(options, false);
  const int64_t session = ShowNext(0).header.session;
  for (int i = 1; i < 20; ++i) {
    idle.Publish(bus::kCamera, bus::ToMessage(other));
    EXPECT_EQ(ShowNext(i).header.session, session);
  }
}

TEST_F(VoNodeTest, ExchangedImagesAreReportedInTheStatus) {
  VoOptions options;
  options.map.enabled = false;
  exchanged_ = true;
  Start(options, true);
  for (int i = 0; i < 20; ++i) ShowNext(i);
  EXPECT_TRUE(Says([](const status_t& s) {
    return s.state == "running" && s.reason.find("plslam rectify-check") != std::string::npos;
  }));
  EXPECT_TRUE(Says([](const status_t& s) {
    return bus::CounterOf(s, "points.seen") > 2000 && bus::CounterOf(s, "frames.dark") == 0;
  }));
  exchanged_ = false;
  for (int i = 0; i < 3; ++i) ShowNext(i, true);
  EXPECT_TRUE(Says([](const status_t& s) { return bus::CounterOf(s, "frames.dark") == 3; }));
}

// The first loop_process may have exited with the request: taken from the bus, but not answered.
TEST_F(VoNodeTest, LocaliseOnlyRestartsInAReplacedMap) {
  VoOptions options;
  options.map.localise_only = true;
  Start(options, false);
  PublishMap(Map());
  const int64_t session = ShowNext(0).header.session;
  EXPECT_EQ(ShowNext(1).header.session, session);
  MapUpdate other = WholeMap(Map());
  other.version = 2;
  other.map_id.n_replaced = 1;
  other.localise_only = true;
  PublishUpdate(other);
  int64_t next = session;
  for (int i = 2; i < 40 && next == session; ++i) next = ShowNext(i).header.session;
  EXPECT_NE(next, session);
}

TEST_F(VoNodeTest, LocaliseOnlyStaysInAGrowingMap) {
  VoOptions options;
  options.map.localise_only = true;
  Start(options, false);
  localise_only_ = false;
  PublishMap(Map());
  for (int i = 0; i < 10; ++i) EXPECT_EQ(ShowNext(i).keyframe_id, -1);
}

TEST_F(VoNodeTest, FramesOfLockstepWaitForTheirMasks) {
  VoOptions options;
  options.map.enabled = false;
  options.masks.enabled = true;
  Start(options, true);
  SayMask(0, {});
  const pose_t without = ShowNext(0);
  EXPECT_GT(without.n_points, 200);
  std::thread detector([&] {
    EXPECT_FALSE(HasPose(1, std::chrono::milliseconds(300)));
    SayMask(1, {{{{{0.0F, 0.0F}, {375.0F, 0.0F}, {375.0F, 119.0F}, {0.0F, 119.0F}}}}, {}});
  });
  const pose_t with = ShowNext(1);
  detector.join();
  EXPECT_GT(with.n_points, 50);
  EXPECT_LT(with.n_points, without.n_points);
  EXPECT_NE(with.state, kLost);
}

TEST_F(VoNodeTest, LiveFrameWaitsBrieflyForItsMask) {
  VoOptions options;
  options.map.enabled = false;
  options.masks.enabled = true;
  Start(options, false);
  for (int i = 0; i < 3; ++i) EXPECT_GT(ShowNext(i).n_points, 200);
  EXPECT_TRUE(Says([](const status_t& status) { return bus::CounterOf(status, "masks.missing") >= 3.0; }));
}

TEST_F(VoNodeTest, SingleMissingMasksAreNotReported) {
  VoOptions options;
  options.map.enabled = false;
  options.masks.enabled = true;
  Start(options, false);
  for (int i = 0; i < 50; ++i) {
    if (i % 2 == 0) SayMask(i, {});
    ShowNext(i);
  }
  EXPECT_TRUE(Says([](const status_t& s) {
    return bus::CounterOf(s, "frames") >= 50.0 && bus::CounterOf(s, "masks.missing") >= 25.0 &&
           s.reason.find("masks do not arrive") == std::string::npos;
  }));
}

VoOptions WithRobot() {
  VoOptions options;
  options.map.enabled = false;
  options.robot_motion.enabled = true;
  return options;
}

TEST_F(VoNodeTest, CoveredCameraFollowsTheWheels) {
  Start(WithRobot(), true);
  const double way_m = (Truth(19).Inverse() * Truth(39)).translation().norm();
  EXPECT_GT(way_m, 1.5);
  EXPECT_LT(ErrorAfterTheDark_m(true), 0.05 * way_m);
}

TEST_F(VoNodeTest, ACoveredCameraWithoutWheelsIsFarOff) {
  VoOptions options = WithRobot();
  bus_options_.partner_wait_s = 0.5;
  Start(options, true);
  EXPECT_GT(ErrorAfterTheDark_m(false), 0.7);
  EXPECT_TRUE(Says([](const status_t& s) { return bus::CounterOf(s, "robot_motions.missing") >= 40.0; }));
}

TEST_F(VoNodeTest, FramesOfLockstepWaitForTheRobot) {
  Start(WithRobot(), true);
  SayWheels(0, 0);
  ShowNext(0);
  std::thread wheels([&] {
    EXPECT_FALSE(HasPose(1, std::chrono::milliseconds(300)));
    SayWheels(1, 1);
  });
  EXPECT_EQ(ShowNext(1).frame_id, 1);
  wheels.join();
}

TEST_F(VoNodeTest, ALiveFrameDoesNotWaitForTheRobot) {
  Start(WithRobot(), false);
  for (int i = 0; i < 3; ++i) EXPECT_GT(ShowNext(i).n_points, 200);
  EXPECT_TRUE(Says([](const status_t& s) { return bus::CounterOf(s, "robot_motions.missing") >= 3.0; }));
}

class VoNodeImuTest : public VoNodeTest {
 protected:
  VoNodeImuTest() : VoNodeTest("&imu=200") {}
};

TEST_F(VoNodeImuTest, FiguresOfTheSensorAreInTheStatus) {
  VoOptions options;
  options.map.enabled = false;
  Start(options, true);
  for (int i = 0; i < 45; ++i) {
    SayImu(i);
    ShowNext(i);
  }
  EXPECT_TRUE(Says([](const status_t& s) { return bus::CounterOf(s, kImuUsed) >= 15.0; })) << "after a second";
  EXPECT_TRUE(Says([](const status_t& s) {
    const double innovation = bus::CounterOf(s, kImuInnovation);
    return innovation > 0.0 && innovation < 4.0;
  }));
  EXPECT_TRUE(Says([](const status_t& s) {
    const double rate = bus::CounterOf(s, kImuRateBiasSigma), force = bus::CounterOf(s, kImuForceBiasSigma);
    return rate > 0.0 && rate < 0.02 && force > 0.0 && force < 1.0 &&
           std::abs(bus::CounterOf(s, kImuForceBias[2])) < 1.0 && bus::CounterOf(s, kImuRateBias[0]) != 0.0;
  }));
}

TEST_F(VoNodeTest, RestartedLoopProcessGetsTheRequestAgain) {
  const Map map = plslam::test::RunSlam(*dataset_, {}, {}, 1, 20).map;
  VoOptions options;
  options.map.localise_only = true;
  Start(options, true);
  PublishMap(map);
  auto first = StartLoopProcess();
  EXPECT_EQ(ShowNext(0).state, kLost);
  ASSERT_TRUE(bus::test::Eventually([&] { return HasAsked(); }));
  first->Join();
  first.reset();
  ForgetQuestion();
  const auto second = StartLoopProcess();
  EXPECT_TRUE(bus::test::Eventually([&] { return HasAsked(); }));
  Answer(map);
  EXPECT_NE(ShowNext(1).state, kLost);
}

TEST_F(VoNodeTest, MovedCameraIsLostUntilALateAnswer) {
  const Map map = plslam::test::RunSlam(*dataset_, {}, {}).map;
  VoOptions options;
  options.map.localise_only = true;
  Start(options, false);
  PublishMap(map);
  const auto find = [&](int index) {
    pose_t pose;
    for (int i = 0; i < 10; ++i) {
      Answer(map);
      pose = ShowNext(index++);
      if (pose.state != kLost) break;
    }
    return pose;
  };
  EXPECT_EQ(ShowNext(0).state, kLost);
  ASSERT_TRUE(bus::test::Eventually([&] { return HasAsked(); }));
  EXPECT_LT(ErrorInMap(find(1)), 0.02);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(ShowNext(10, true).state, kLost);
  // Among its own landmarks it is tracked at once, and relocalised after a bad frame; in the map it is not localised.
  for (int i = 60; i < 64; ++i) {
    if (i == 62) {
      EXPECT_EQ(ShowNext(i, true).state, kLost);
    }
    const pose_t pose = ShowNext(i);
    EXPECT_EQ(pose.state, kLost) << i;
    EXPECT_GT(pose.covariance[0], i > 60 ? 10.0 : 0.0) << i;
  }
  const pose_t found = find(64);
  EXPECT_NE(found.state, kLost);
  EXPECT_LT(ErrorInMap(found), 0.02);
  EXPECT_LT(found.covariance[0], 1e3);
}

}  // namespace
}  // namespace plslam::vo
