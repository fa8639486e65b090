// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "core/bus/messages/convert.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/stock_lcm.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "core/geometry/body_frame.h"
#include "core/run/tracking_state.h"
#include "plslam/imu_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/robot_motion_t.hpp"
#include "plslam/stage_t.hpp"
#include "sensor_msgs/Image.hpp"
#include "tests/integration/bus_frames.h"
#include "tests/integration/by_hand.h"
#include "tests/integration/lcm_robot.h"
#include "tests/integration/whole_run.h"
#include "tests/support/data_folder.h"
#include "tests/support/python.h"
#include "tests/support/sanitized.h"
#include "tests/support/shell.h"
#include "tests/support/text_file.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam {
namespace {

using test::ByHand;
using test::LcmRobot;
using test::RobotImages;
using test::WholeRun;

#ifdef PLSLAM_SANITIZED
constexpr double kRate_hz = 2.0;
#else
constexpr double kRate_hz = 20.0;
#endif

/// Arrival times of poses on our own bus, by their stamps, and the robot's counters.
class OwnPoses {
 public:
  explicit OwnPoses(const std::string& url) : bus_(test::BusFrames::OptionsOf(url)) {
    bus_->SubscribeBytes(
        bus::kPose, bus::Bus::Reading::kAsItComes, [] { return true; },
        [this](bus::ByteView bytes) {
          const std::scoped_lock lock(mutex_);
          at_s_.emplace(bus::ReadHeader(bytes).t_ns, bus::NowS());
        });
    bus_->Subscribe<robot_motion_t>(bus::kRobotMotion, [this](const robot_motion_t& motion) {
      const std::scoped_lock lock(mutex_);
      motions_.emplace(motion.header.t_ns, *bus::FromMessage(motion.T_robot_b));
    });
    bus_->Subscribe<imu_t>(bus::kImu, [this](const imu_t& message) {
      const std::scoped_lock lock(mutex_);
      if (message.complete != 0) n_samples_[message.header.t_ns] = message.n_samples;
    });
    bus_.Start();
  }
  ~OwnPoses() { bus_.Join(); }

  std::map<int64_t, double> at_s() const {
    const std::scoped_lock lock(mutex_);
    return at_s_;
  }

  /// Numbers of samples of the inertial sensor in front of a frame, by its stamp.
  std::map<int64_t, int> n_samples() const {
    const std::scoped_lock lock(mutex_);
    return n_samples_;
  }

  /// The robot's own odometry.
  std::map<int64_t, SE3> motions() const {
    const std::scoped_lock lock(mutex_);
    return motions_;
  }

 private:
  mutable std::mutex mutex_;
  std::map<int64_t, double> at_s_;
  std::map<int64_t, SE3> motions_;
  std::map<int64_t, int> n_samples_;
  bus::test::RunningBus bus_;
};

/// A robot with images of one kind, and the processes beside it.
class Adapter : public testing::Test {
 protected:
  void Start(const std::string& world, RobotImages images, bool one_bus, bool whole) {
    url_ = bus::test::PrivateUrl();
    foreign_url_ = one_bus ? url_ : bus::test::PrivateUrl();
    world_ = OpenDataset(world, "");
    robot_ = std::make_unique<LcmRobot>(foreign_url_, *world_, images);
    run_ = std::make_unique<ByHand>(url_);
    own_ = std::make_unique<OwnPoses>(url_);
    std::ofstream(run_->folder() / "camera.yaml") << CameraFileText(world_->rig());
    if (whole) {
      run_->StartPlain("mapping_process", {"--url", url_});
      run_->StartPlain("loop_process", {"--url", url_});
      run_->StartPlain("vo_process", {"--url", url_});
    } else {
      const char* const wheels = world_->rig().imu ? "false" : "true";
      run_->StartPlain("vo_process", {"--url", url_, "--set", "vo.map.enabled=false", "--set",
                                      std::string("vo.robot_motion.enabled=") + wheels});
    }
    StartAdapter();
  }

  void StartAdapter() {
    std::vector<std::string> arguments = robot_->AdapterArguments((run_->folder() / "camera.yaml").string());
    arguments.insert(arguments.end(), {"--foreign-url", foreign_url_, "--url", url_, "--set",
                                       std::string("adapter.robot_odometry=") + test::kWheelsChannel});
    if (world_->rig().imu) {
      arguments.insert(arguments.end(), {"--set", std::string("adapter.imu=") + test::kImuChannel});
    }
    run_->StartPlain("adapter", arguments);
  }

  /// Drives on the spot until the first pose is back: processes take their time to start.
  void WaitForTheFirstPose() {
    ASSERT_TRUE(WholeRun::WaitFor([&] {
      robot_->Drive(0, 1, kRate_hz);
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      return !robot_->poses().empty();
    })) << run_->Logs();
  }

  /// Returns whether the last frame has a pose, or one of the few before it: lost images are not resent.
  bool HasPoseOfLast(int n_frames) const {
    const auto poses = PosesByTime();
    for (int i = n_frames - 5; i < n_frames; ++i) {
      if (poses.contains(robot_->t_ns(i))) return true;
    }
    return false;
  }

  std::map<int64_t, bot_core::pose_t> PosesByTime() const {
    std::map<int64_t, bot_core::pose_t> poses;
    for (const auto& heard : robot_->poses()) poses[1000 * heard.message.utime] = heard.message;
    return poses;
  }

  /// Returns the true pose of the body at a frame, in the axes of the body at frame 0.
  SE3 Truth(int frame) const {
    const SE3 T_b_c = BodyFromCamera(world_->rig());
    const SE3 T_first_l = world_->GroundTruth(0)->Inverse() * *world_->GroundTruth(frame);
    return T_b_c * T_first_l * T_b_c.Inverse();
  }

  /// Root mean square of the errors of position; fails where fewer than `least` of the frames have a pose.
  double Rmse_m(int begin, int end, size_t least) const {
    const auto poses = PosesByTime();
    double sum = 0.0;
    size_t n = 0;
    for (int i = begin; i < end; ++i) {
      const auto pose = poses.find(robot_->t_ns(i));
      if (pose == poses.end()) continue;
      const Eigen::Vector3d p(pose->second.pos[0], pose->second.pos[1], pose->second.pos[2]);
      sum += (p - Truth(i).translation()).squaredNorm();
      ++n;
    }
    EXPECT_GE(n, least) << run_->Logs();
    return std::sqrt(sum / static_cast<double>(std::max<size_t>(n, 1)));
  }

  /// Returns the delay of poses on the robot's bus after ours: the lower quartile, which other busy programs do not
  /// affect.
  double Delay_ms() const {
    const auto own = own_->at_s();
    std::vector<double> delays;
    for (const auto& heard : robot_->poses()) {
      const auto at = own.find(1000 * heard.message.utime);
      if (at != own.end()) delays.push_back(1e3 * (heard.at_s - at->second));
    }
    if (delays.empty()) return 1e9;
    const auto quartile = delays.begin() + static_cast<std::ptrdiff_t>(delays.size() / 4);
    std::nth_element(delays.begin(), quartile, delays.end());
    return *quartile;
  }

  std::string url_, foreign_url_;
  std::unique_ptr<Dataset> world_;
  std::unique_ptr<ByHand> run_;
  std::unique_ptr<OwnPoses> own_;
  std::unique_ptr<LcmRobot> robot_;
};

constexpr int kFrames = 200;
const std::string kWorld = fmt::format("synthetic:room?size=376x240&frames={}&rate=20", kFrames);

/// As with the player in real time, although the adapter is killed on the way; all on one bus.
TEST_F(Adapter, RobotWithImagePairsIsLocalisedAcrossAKill) {
  Start(kWorld, RobotImages::kBotGrey, true, true);
  ASSERT_NO_FATAL_FAILURE(WaitForTheFirstPose());
  robot_->Drive(1, kFrames / 2, kRate_hz);
  run_->Kill("adapter");
  StartAdapter();
  robot_->Drive(kFrames / 2, kFrames, kRate_hz);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasPoseOfLast(kFrames); })) << run_->Logs();
  ASSERT_TRUE(WholeRun::WaitFor([&] { return robot_->maps().size() > 2; })) << run_->Logs();

  WholeRun played;
  ASSERT_EQ(played.Run({"run", kWorld, "--pace", "realtime", "--no-loops"}), 0) << played.Logs();
  const double expected_m = played.Summary()["accuracy_live_ate_m"].get<double>();
  // Frames sent without an adapter have no poses, nor have those that a busy machine drops.
  constexpr size_t kLeast = kFrames / 2;
  const double rmse_m = Rmse_m(1, kFrames, kLeast), delay_ms = Delay_ms();
  std::cout << fmt::format("{:.4f} m, {:.4f} m with the player; {:.3f} ms behind our bus\n", rmse_m, expected_m,
                           delay_ms);
  EXPECT_LT(rmse_m, 2.0 * expected_m + 0.01);
#ifndef PLSLAM_SANITIZED
  EXPECT_LT(delay_ms, 5.0);
#endif
  const auto odometry = robot_->odometry();
  const auto transforms = robot_->transforms();
  EXPECT_GE(odometry.size(), kLeast);
  EXPECT_GE(transforms.size(), kLeast);
  EXPECT_EQ(odometry.back().message.child_frame_id, "base_link");
  EXPECT_GT(odometry.back().message.pose.covariance[0], 0.0);
  EXPECT_GT(robot_->maps().back().message.width, 100);
  EXPECT_TRUE(run_->StopAll()) << run_->Logs();
}

class AdapterInputs : public Adapter, public testing::WithParamInterface<RobotImages> {};

TEST_P(AdapterInputs, EachImageFormatIsTracked) {
  constexpr int kFew = 40;
  Start(fmt::format("synthetic:room?size=376x240&frames={}&rate=20", kFew), GetParam(), false, false);
  ASSERT_NO_FATAL_FAILURE(WaitForTheFirstPose());
  robot_->Drive(1, kFew, kRate_hz);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasPoseOfLast(kFew); })) << run_->Logs();
  EXPECT_LT(Rmse_m(1, kFew, kFew / 2), 0.02);
  // The velocity is the way over the time, of frames that follow each other; most of them do.
  const auto poses = PosesByTime();
  std::vector<double> errors;
  for (int i = 2; i < kFew; ++i) {
    const auto pose = poses.find(robot_->t_ns(i));
    if (pose == poses.end() || !poses.contains(robot_->t_ns(i - 1))) continue;
    const double dt_s = 1e-9 * static_cast<double>(robot_->t_ns(i) - robot_->t_ns(i - 1));
    const SE3 motion = Truth(i - 1).Inverse() * Truth(i);
    const Eigen::Vector3d velocity(pose->second.vel[0], pose->second.vel[1], pose->second.vel[2]);
    errors.push_back((velocity - motion.translation() / dt_s).norm());
  }
  ASSERT_GT(errors.size(), 5U);
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2), errors.end());
  EXPECT_LT(errors[errors.size() / 2], 0.2);
  const std::map<int64_t, SE3> motions = own_->motions();
  size_t n_motions = 0;
  for (int i = 1; i < kFew; ++i) {
    const auto motion = motions.find(robot_->t_ns(i));
    if (motion == motions.end()) continue;
    ++n_motions;
    EXPECT_LT((motion->second.Inverse() * Truth(i)).Log().norm(), 1e-6) << i;
  }
  EXPECT_GE(n_motions, kFew / 2U);
  EXPECT_TRUE(run_->StopAll()) << run_->Logs();
}

/// The images are black for 15 frames, in which the sensor carries the pose.
TEST_F(Adapter, InertialSensorCarriesThroughDarkness) {
  constexpr int kMany = 120, kDark = 80, kLight = 95;
  Start(fmt::format("synthetic:room?size=376x240&frames={}&rate=20&imu=200", kMany), RobotImages::kBotGrey, false,
        false);
  robot_->Cover(kDark, kLight);
  ASSERT_NO_FATAL_FAILURE(WaitForTheFirstPose());
  robot_->Drive(1, kMany, kRate_hz);
  ASSERT_TRUE(WholeRun::WaitFor([&] { return HasPoseOfLast(kMany); })) << run_->Logs();
  int n_complete = 0;
  const std::map<int64_t, int> n_samples = own_->n_samples();
  for (int i = 1; i < kMany; ++i) {
    const auto found = n_samples.find(robot_->t_ns(i));
    // 200 Hz between frames of 20 Hz, and around both ends.
    n_complete += found != n_samples.end() && (found->second == 11 || found->second == 12);
  }
  EXPECT_GE(n_complete, kMany * 3 / 4) << testing::PrintToString(n_samples);
  EXPECT_LT(Rmse_m(kDark, kLight, (kLight - kDark) / 3), 0.05);
  EXPECT_TRUE(run_->StopAll()) << run_->Logs();
}

TEST(AdapterChannels, ThoseWithImagesAreListed) {
  const WholeRun run;
  const std::string foreign = bus::test::PrivateUrl();
  const launcher::ChildProcess adapter(test::BinaryFolder() / "adapter",
                                       {"--url", bus::test::PrivateUrl(), "--set", "adapter.foreign_url=" + foreign,
                                        "--set", "adapter.left=/lefft", "--set", "adapter.right=/right"},
                                       run.folder() / "adapter.log");
  bus::StockLcm robot(foreign, "foreign");
  const auto log = [&] { return ReadText(run.folder() / "adapter.log"); };
  EXPECT_TRUE(WholeRun::WaitFor([&] {
    robot.Publish("/left", bus::Encoded(sensor_msgs::Image()));
    return log().find("images are on /left") != std::string::npos;
  })) << log();
  EXPECT_NE(log().find("waiting for images on /lefft and /right"), std::string::npos) << log();
}

/// The example tools/python/examples/send_images.py: a wall 2 m away, passed at 0.4 m/s.
TEST(AdapterPython, ImagesOfNumpyAreTracked) {
  const std::string python = test::PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy here";
  const std::string url = bus::test::PrivateUrl(), foreign = bus::test::PrivateUrl();
  ByHand run(url);
  std::mutex mutex;
  std::vector<pose_t> poses;
  bus::BusOptions options;
  options.url = url;
  bus::test::RunningBus listener(options, "listener");
  listener->Subscribe<pose_t>(bus::kPose, [&](const pose_t& pose) {
    const std::scoped_lock lock(mutex);
    poses.push_back(pose);
  });
  listener.Start();
  std::ofstream(run.folder() / "camera.yaml")
      << "rate_hz: 20\nbaseline_m: 0.1\nleft:\n  resolution_px: [376, 240]\n  focal_length_px: [200, 200]\n"
         "  principal_point_px: [187.5, 119.5]\n";
  run.StartPlain("vo_process", {"--url", url, "--set", "vo.map.enabled=false"});
  run.StartPlain("adapter", {"--images", "CAMERA", "--camera", (run.folder() / "camera.yaml").string(), "--url", url,
                             "--foreign-url", foreign});
  const ScratchFolder folder;
  const test::ShellResult sent = test::Shell(
      folder,
      fmt::format("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='{}' {} '{}/tools/python/examples/send_images.py' '{}'",
                  PLSLAM_PYTHON_FOLDER, python, test::SourceFolder().string(), foreign));
  ASSERT_EQ(sent.exit_code, 0) << sent.error;
  ASSERT_TRUE(WholeRun::WaitFor([&] {
    const std::scoped_lock lock(mutex);
    return poses.size() > 60;
  })) << run.Logs();
  const std::scoped_lock lock(mutex);
  const pose_t &first = poses[20], &last = poses[60];
  EXPECT_EQ(last.state, static_cast<int8_t>(TrackingState::kTracking));
  const double metres = last.T_odom_c.position_m[0] - first.T_odom_c.position_m[0];
  const double expected = 0.4e-9 * static_cast<double>(last.header.t_ns - first.header.t_ns);
  EXPECT_NEAR(metres, expected, 0.03 * expected);
  listener.Join();
}

INSTANTIATE_TEST_SUITE_P(Inputs, AdapterInputs,
                         testing::Values(RobotImages::kBotJpeg, RobotImages::kRosColour,
                                         RobotImages::kRosCompressed));

}  // namespace
}  // namespace plslam
