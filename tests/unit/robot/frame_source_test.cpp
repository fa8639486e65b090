// SPDX-License-Identifier: BSD-3-Clause
#include "core/robot/node/frame_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/run_loop.h"
#include "core/files/dataset_error.h"
#include "plslam/camera_t.hpp"
#include "plslam/imu_t.hpp"
#include "plslam/warning_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::robot {
namespace {

using bus::test::Eventually;
using testing::HasSubstr;

constexpr int64_t kFrame_ns = 50'000'000, kSample_ns = 5'000'000;

constexpr const char* kCamera =
    "baseline_m: 0.1\nleft: {resolution_px: [64, 48], focal_length_px: [40, 40], principal_point_px: [32, 24]}\n";
constexpr const char* kPose = "T_c_imu: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0]\n";

ForeignImage Image(int64_t t_ns) {
  ForeignImage image;
  image.t_ns = t_ns;
  image.width_px = 64;
  image.height_px = 48;
  image.encoding = "mono8";
  image.bytes.resize(64 * 48);
  return image;
}

/// The source of a robot with an inertial sensor, and a listener on the bus.
class FrameSourceImu : public testing::Test {
 protected:
  FrameSourceImu() {
    options_.url = bus::test::PrivateUrl();
    listener_ = std::make_unique<bus::test::RunningBus>(options_, "listener");
    (*listener_)->Subscribe<imu_t>(bus::kImu, [this](const imu_t& message) {
      const std::scoped_lock lock(mutex_);
      imu_.push_back(message);
    });
    (*listener_)->Subscribe<camera_t>(bus::kCamera, [this](const camera_t& message) {
      const std::scoped_lock lock(mutex_);
      rig_kind_ = message.kind;
    });
    (*listener_)->Subscribe<warning_t>(bus::kWarning, [this](const warning_t& message) {
      const std::scoped_lock lock(mutex_);
      warnings_ += message.code + ": " + message.sentence + "\n";
    });
    listener_->Start();
    process_ = std::make_unique<bus::Process>("adapter", options_);
    runs_ = std::thread([this] { process_->bus().Run(); });
  }
  ~FrameSourceImu() override {
    process_->bus().Stop();
    runs_.join();
    listener_->Join();
  }

  void Start(const std::string& camera, const std::string& imu_calibration = "") {
    Write("camera.yaml", camera);
    if (!imu_calibration.empty()) Write("imu.yaml", imu_calibration);
    source_ = std::make_unique<FrameSource>(
        *process_,
        FrameSource::Settings{.process = "adapter",
                              .camera_option = "adapter.camera",
                              .camera = folder_ / "camera.yaml",
                              .left = "/pair",
                              .right = "",
                              .max_skew_ns = 0,
                              .imu = {.name = "/imu",
                                      .option = "adapter.imu",
                                      .calibration = imu_calibration.empty() ? "" : folder_ / "imu.yaml",
                                      .camera = folder_ / "camera.yaml"}},
        FrameSource::Listener{[](const RigCalibration&) {}, [](int64_t) {}});
  }
  void Write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  void AddSamples(int64_t from_ns, int64_t to_ns) {
    for (int64_t t = from_ns; t <= to_ns; t += kSample_ns) source_->imu().Add({.t_ns = t});
  }
  void AddPair(int64_t t_ns) { source_->AddPair(Image(t_ns), Image(t_ns)); }
  std::vector<imu_t> Imu() const {
    const std::scoped_lock lock(mutex_);
    return imu_;
  }
  std::string Warnings() const {
    const std::scoped_lock lock(mutex_);
    return warnings_;
  }
  std::string RigKind() const {
    const std::scoped_lock lock(mutex_);
    return rig_kind_;
  }

  bus::test::TemporaryFolder folder_;
  bus::BusOptions options_;
  mutable std::mutex mutex_;
  std::vector<imu_t> imu_;
  std::string warnings_, rig_kind_;
  std::unique_ptr<bus::test::RunningBus> listener_;
  std::unique_ptr<bus::Process> process_;
  std::unique_ptr<FrameSource> source_;
  std::thread runs_;
};

TEST_F(FrameSourceImu, SamplesLeadToTheirFrame) {
  Start(std::string(kCamera) + "imu: {" + std::string(kPose, std::string(kPose).size() - 1) + "}\n");
  AddSamples(kFrame_ns - kSample_ns, kFrame_ns + kSample_ns);
  AddPair(kFrame_ns);
  EXPECT_EQ(source_->n_sent(), 1) << "its samples are there";
  AddPair(2 * kFrame_ns);
  EXPECT_EQ(source_->n_sent(), 1) << "it waits";
  AddSamples(kFrame_ns + 2 * kSample_ns, 2 * kFrame_ns);
  source_->SendDue();
  EXPECT_EQ(source_->n_sent(), 2);
  ASSERT_TRUE(Eventually([&] { return Imu().size() == 2; }));
  const imu_t second = Imu()[1];
  EXPECT_EQ(second.header.t_ns, 2 * kFrame_ns);
  EXPECT_EQ(second.from_ns, kFrame_ns);
  EXPECT_EQ(second.complete, 1);
  ASSERT_EQ(second.n_samples, 11) << "at both ends, too";
  EXPECT_EQ(second.samples.front().t_ns, kFrame_ns);
  EXPECT_EQ(second.samples.back().t_ns, 2 * kFrame_ns);
  source_->PublishRig();
  EXPECT_TRUE(Eventually([&] { return RigKind().find(" imu 0.5 0 0 ") != std::string::npos; })) << RigKind();
}

TEST_F(FrameSourceImu, WaitIsShortAndLateSamplesFollow) {
  Start(kCamera, kPose);
  AddSamples(0, kFrame_ns);
  AddPair(kFrame_ns);
  AddPair(2 * kFrame_ns);
  AddSamples(kFrame_ns + kSample_ns, kFrame_ns + 2 * kSample_ns);
  const double began_s = bus::NowS();
  while (source_->n_sent() < 2 && bus::NowS() < began_s + 5.0) {
    std::this_thread::sleep_for(source_->Wait(std::chrono::milliseconds(100)));
    source_->SendDue();
  }
  EXPECT_GE(bus::NowS() - began_s, 0.5 * FrameSource::kImuWait_s);
  ASSERT_EQ(source_->n_sent(), 2);
  AddSamples(kFrame_ns + 3 * kSample_ns, 3 * kFrame_ns);
  AddPair(3 * kFrame_ns);
  ASSERT_TRUE(Eventually([&] { return Imu().size() == 3; }));
  EXPECT_EQ(Imu()[1].n_samples, 3) << "what there is";
  EXPECT_EQ(Imu()[1].complete, 1);
  EXPECT_EQ(Imu()[2].from_ns, kFrame_ns) << "the last frame with all samples up to it";
  EXPECT_EQ(Imu()[2].n_samples, 21);
  AddSamples(3 * kFrame_ns + kSample_ns, 4 * kFrame_ns);
  AddPair(4 * kFrame_ns);
  ASSERT_TRUE(Eventually([&] { return Imu().size() == 4; }));
  EXPECT_EQ(Imu()[3].from_ns, 3 * kFrame_ns) << "they are sent once";
  EXPECT_EQ(Imu()[3].n_samples, 11);
}

TEST_F(FrameSourceImu, SilentSensorDelaysNothingAndIsReported) {
  Start(kCamera, kPose);
  for (int i = 1; i <= 30; ++i) {
    AddPair(i * kFrame_ns);
    ASSERT_EQ(source_->n_sent(), i);
  }
  EXPECT_TRUE(Eventually([&] { return !Warnings().empty(); }));
  EXPECT_THAT(Warnings(), HasSubstr("imu_missing: no sample of the inertial sensor arrives on /imu (adapter.imu)"));
}

TEST_F(FrameSourceImu, OtherClockIsReported) {
  Start(kCamera, kPose);
  for (int i = 1; i <= 30; ++i) {
    source_->imu().Add({.t_ns = i * kFrame_ns});
    AddPair(100 * kFrame_ns + i * kFrame_ns);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(Eventually([&] {
    source_->SendDue();
    return !Warnings().empty();
  }));
  EXPECT_THAT(Warnings(), HasSubstr("older than the images"));
}

TEST_F(FrameSourceImu, ClockAheadIsReported) {
  Start(kCamera, kPose);
  for (int i = 1; i <= 30; ++i) {
    source_->imu().Add({.t_ns = 100 * kFrame_ns + i * kFrame_ns});
    AddPair(i * kFrame_ns);
    ASSERT_EQ(source_->n_sent(), i);
  }
  EXPECT_TRUE(Eventually([&] { return !Warnings().empty(); }));
  EXPECT_THAT(Warnings(), HasSubstr("newer than the images"));
}

TEST_F(FrameSourceImu, SensorWithoutAPoseIsNotUsed) {
  Start(kCamera);
  AddSamples(0, kFrame_ns);
  AddPair(kFrame_ns);
  EXPECT_EQ(source_->n_sent(), 1);
  EXPECT_TRUE(Eventually([&] { return !Warnings().empty(); }));
  EXPECT_THAT(Warnings(),
              HasSubstr("imu_uncalibrated: /imu: the inertial sensor is not used, because its pose is not "
                        "known: write T_c_imu (docs/imu.md) to a file, and give "
                        "adapter.imu_calibration=FILE"));
  EXPECT_TRUE(Imu().empty());
}

TEST_F(FrameSourceImu, FileThatIsMissingOrWrongEndsTheStart) {
  EXPECT_THROW(Start(kCamera, "gyroscope_noise_density: 1\n"), DatasetError);
  std::filesystem::remove(folder_ / "imu.yaml");
  Write("camera.yaml", kCamera);
  FrameSource::Settings settings;
  settings.camera = folder_ / "camera.yaml";
  settings.imu.name = "/imu";
  settings.imu.calibration = folder_ / "imu.yaml";
  EXPECT_THROW(FrameSource(*process_, settings, {}), DatasetError);
}

}  // namespace
}  // namespace plslam::robot
