// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/imu_files.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/datasets/images_dataset.h"
#include "core/datasets/kitti_dataset.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kPose = "T_b_imu: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3]\n";
constexpr const char* kNoise =
    "gyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 2.0e-5\n"
    "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n";

/// Lines of a map, each with this indent.
std::string Indented(const std::string& lines) {
  std::string text = "  ";
  for (const char c : lines) text += c == '\n' ? std::string("\n  ") : std::string(1, c);
  return text.substr(0, text.size() - 2);
}

/// A folder of images at 0.5 to 0.75 s, with samples of the same time.
class ImuFile : public testing::Test {
 protected:
  ImuFile() {
    test::MakeImagesFolder(folder_);
    WriteSamples(1.0);
  }
  /// 100 samples from 0.45 s on, 5 ms apart, in units of this many nanoseconds.
  void WriteSamples(double unit_ns, double from_s = 0.45) const {
    std::string csv = "#timestamp,w_x,w_y,w_z,a_x,a_y,a_z\n";
    for (int i = 0; i < 100; ++i) {
      const double t_ns = 1e9 * from_s + 5e6 * i;
      csv += unit_ns == 1e9 ? fmt::format("{:.6f}", t_ns / unit_ns) : fmt::format("{:.0f}", t_ns / unit_ns);
      csv += ",0.1,0.2,0.3,0,0,9.8\n";
    }
    test::WriteText(folder_ / "imu.csv", csv);
  }
  std::unique_ptr<Dataset> Open(const std::string& imu_yaml) const {
    test::WriteText(folder_ / "imu.yaml", imu_yaml);
    return OpenImagesDataset(folder_.string());
  }
  std::string Error(const std::string& imu_yaml) const {
    return ErrorOf([&] { Open(imu_yaml); });
  }
  /// Gives the left camera a pose in the body.
  void MoveLeftCamera() const {
    test::ReplaceText(folder_ / "camera.yaml", "left:\n", "left:\n  T_b_cam: [1,0,0,0.5, 0,1,0,0, 0,0,1,0]\n");
  }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "own";
};

TEST_F(ImuFile, IsReadInEachForm) {
  const std::string own = kPose + std::string(kNoise);
  ImuCalibration imu;
  imu.T_b_imu = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(0.1, 0.2, 0.3));
  imu.time_offset_s = -0.002;
  imu.rate_hz = 200.0;
  for (const std::string& text :
       {own + "rate_hz: 200\ntime_offset_s: -0.002\n",
        "imu:\n" + Indented(own + "rate_hz: 200\ntime_offset_s: -0.002\n"),
        "imu0:\n" + Indented(own + "update_rate: 200.0\nrostopic: /imu0\nmodel: calibrated\n"
                                   "time_offset: 0.0\ntime_offset_s: -0.002\n"),
        ImuFileText(imu)}) {
    const auto dataset = Open(text);
    ASSERT_TRUE(dataset->rig().imu) << text;
    EXPECT_EQ(dataset->rig().imu->T_b_imu.translation(), Eigen::Vector3d(0.1, 0.2, 0.3)) << text;
    EXPECT_EQ(dataset->rig().imu->time_offset_s, -0.002) << text;
    EXPECT_EQ(dataset->rig().imu->rate_hz, 200.0) << text;
    EXPECT_EQ(dataset->ImuSamples().size(), 100U) << text;
    EXPECT_TRUE(dataset->Notes().empty()) << text;
  }
}

TEST_F(ImuFile, UnknownKeysAreRefused) {
  EXPECT_THAT(Error("T_c_imuu: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\n"),
              AllOf(HasSubstr("imu.yaml:1: T_c_imuu is not a known key"), HasSubstr("T_c_imu")));
  EXPECT_THAT(Error("imu:\n  gyro_noise: 1\n"), HasSubstr("imu.yaml:2: gyro_noise is not a known key"));
  EXPECT_THAT(Error("imu0:\n  T_i_b: [1,0,0,1, 0,1,0,0, 0,0,1,0]\n"),
              HasSubstr("imu.yaml:2: T_i_b is not the identity, as that of Kalibr's imu0 is: give imu0"));
  EXPECT_THAT(Error("time_offset: 0.01\n"), HasSubstr("time_offset = 0.01 is not 0"));
  EXPECT_THAT(Error("time_offset_s: 2\n"), HasSubstr("imu.yaml:1: time_offset_s = 2 is not within -1 to 1"));
}

TEST_F(ImuFile, OneWithoutAPoseNeedsABody) {
  const auto lost = Open(kNoise);
  EXPECT_FALSE(lost->rig().imu) << "axes of the sensor are not those of the camera";
  EXPECT_THAT(lost->ImuSamples(), IsEmpty());
  EXPECT_THAT(lost->Notes().warnings,
              ElementsAre(AllOf(HasSubstr("imu.csv: the inertial sensor is not used: its pose is not known"),
                                HasSubstr("write T_c_imu"), HasSubstr((folder_ / "imu.yaml").string()))));
  MoveLeftCamera();
  const auto found = Open(kNoise);
  ASSERT_TRUE(found->rig().imu) << "the pose of the left camera is in the sensor";
  EXPECT_TRUE(found->rig().imu->T_b_imu.matrix().isIdentity());
  EXPECT_TRUE(found->Notes().empty());
}

TEST_F(ImuFile, KittiHasNoBodyButTheCamera) {
  const fs::path kitti = temporary_.path() / "kitti";
  test::MakeKittiFolder(kitti);
  std::string csv;
  for (int i = 0; i < 100; ++i) csv += fmt::format("{},0,0,0,0,0,9.8\n", 5'000'000 * i);
  test::WriteText(kitti / "imu.csv", csv);
  test::WriteText(kitti / "imu.yaml", kNoise);
  EXPECT_FALSE(OpenKittiDataset(kitti.string())->rig().imu);
  test::WriteText(kitti / "imu.yaml", std::string(kNoise) + "T_c_imu: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]\n");
  EXPECT_TRUE(OpenKittiDataset(kitti.string())->rig().imu);
}

TEST_F(ImuFile, CameraFileAndItsOwnFileAddUp) {
  test::WriteText(folder_ / "camera.yaml",
                  test::ReadText(folder_ / "camera.yaml") + "imu:\n  T_c_imu: [1,0,0,0.4, 0,1,0,0, 0,0,1,0]\n");
  const auto remarked = Open("rate_hz: 200\n");
  ASSERT_TRUE(remarked->rig().imu);
  EXPECT_THAT(remarked->Notes().remarks, ElementsAre(HasSubstr("imu.csv has no noise densities")));
  const auto dataset = Open(std::string(kPose) + kNoise);
  ASSERT_TRUE(dataset->rig().imu);
  EXPECT_EQ(dataset->rig().imu->T_b_imu.translation().x(), 0.4) << "the camera file is decisive";
  EXPECT_EQ(dataset->rig().imu->noise.accelerometer_walk_m_s3_sqrt_hz, 3e-3);
  EXPECT_TRUE(dataset->Notes().empty());
}

TEST_F(ImuFile, TimesInAnotherUnitAreRefused) {
  WriteSamples(1e9);
  EXPECT_THAT(Error(kPose),
              HasSubstr("imu.csv:2: time 0.450000 is not a whole number of nanoseconds; is it in seconds?"));
  for (const double from_s : {0.45, 1403636580.0}) {
    WriteSamples(1e3, from_s);
    EXPECT_THAT(Error(kPose), AllOf(HasSubstr("imu.csv: times must be in nanoseconds, but then samples would be 5000 "
                                              "ns apart in the median, not 100000 to 1000000000 ns"),
                                    HasSubstr("are they in microseconds?")));
    WriteSamples(1e6, from_s);
    EXPECT_THAT(Error(kPose), HasSubstr("are they in milliseconds?"));
  }
}

TEST_F(ImuFile, SamplesOfAnotherTimeAreNotUsed) {
  WriteSamples(1.0, 3600.0);
  const auto dataset = Open(kPose);
  EXPECT_FALSE(dataset->rig().imu);
  EXPECT_THAT(dataset->ImuSamples(), IsEmpty());
  EXPECT_THAT(
      dataset->Notes().warnings,
      ElementsAre(AllOf(HasSubstr("imu.csv: the inertial sensor is not used: its samples are of 3600.000000000 "
                                  "s to 3600.495000000 s, but the images of 0.500000000 s to 0.750000000 s"),
                        HasSubstr("state time_offset_s"))));
}

TEST_F(ImuFile, ScaleAndMisalignmentAreNotApplied) {
  const auto dataset = Open(std::string(kPose) + kNoise + "Tw: [[1.01, 0, 0], [0, 1, 0], [0, 0, 1]]\n");
  EXPECT_THAT(dataset->Notes().warnings, ElementsAre(HasSubstr("imu.yaml:6: Tw is not applied")));
  EXPECT_TRUE(Open(std::string(kPose) + kNoise + "Tw: [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\n")->Notes().empty());
}

}  // namespace
}  // namespace plslam
