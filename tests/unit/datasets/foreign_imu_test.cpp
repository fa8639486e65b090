// SPDX-License-Identifier: BSD-3-Clause
// The inertial sensor in the calibrations of other programs.
#include "core/datasets/asl_sensor.h"
#include "core/datasets/camera_file.h"
#include "core/datasets/imu_files.h"
#include "tests/unit/datasets/foreign_calibration_fixture.h"

namespace plslam {
namespace {

using test::ErrorOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* kNoise =
    "gyroscope_noise_density: 1e-4\ngyroscope_random_walk: 2e-5\naccelerometer_noise_density: 3e-3\n"
    "accelerometer_random_walk: 4e-4\n";

class ForeignImu : public test::ForeignCalibrationTest {
 protected:
  /// The rig of this file with more text, as a camera file.
  RigCalibration Read(const std::string& file, const std::string& more = "") {
    const test::ForeignRig& rig = RigCalled(file);
    std::vector<std::string> paths = WriteAll(rig);
    if (!more.empty()) Write(file, rig.files.front().text + more);
    notes_ = {};
    imu_notes_ = {};
    parts_ = ReadForeignImu(paths, std::nullopt, &imu_notes_);
    return ReadCalibration(paths, kSize, &notes_);
  }
  static void ExpectNoise(const RigCalibration& rig) {
    ASSERT_TRUE(rig.imu);
    EXPECT_EQ(rig.imu->noise.gyroscope_rad_s_sqrt_hz, 1e-4);
    EXPECT_EQ(rig.imu->noise.gyroscope_walk_rad_s2_sqrt_hz, 2e-5);
    EXPECT_EQ(rig.imu->noise.accelerometer_m_s2_sqrt_hz, 3e-3);
    EXPECT_EQ(rig.imu->noise.accelerometer_walk_m_s3_sqrt_hz, 4e-4);
  }
  /// Body is the sensor, which is where the poses of the cameras say.
  static void ExpectBody(const RigCalibration& rig) {
    ASSERT_TRUE(rig.imu);
    EXPECT_TRUE(rig.imu->T_b_imu.matrix().isIdentity());
  }

  ImuParts parts_;
  Notes notes_, imu_notes_;
};

TEST_F(ForeignImu, KalibrChainAndTheFileBesideIt) {
  const std::string shifted = Replaced(RigCalled("openvins.yaml").files.front().text, "  camera_model: pinhole\n",
                                       "  camera_model: pinhole\n  timeshift_cam_imu: 0.02\n");
  const auto read = [&](const std::string& path) { return ReadCalibration({path}, kSize, &notes_); };
  const RigCalibration alone = read(Write("camchain-imucam-a.yaml", shifted));
  ExpectBody(alone);
  EXPECT_EQ(alone.imu->time_offset_s, -0.02) << "t_imu = t_cam + shift, so t_cam = t_imu - shift";
  EXPECT_EQ(alone.imu->noise.gyroscope_rad_s_sqrt_hz, ImuNoise().gyroscope_rad_s_sqrt_hz);
  Write("imu-a.yaml",
        "imu0:\n  T_i_b: [[1,0,0,0], [0,1,0,0], [0,0,1,0], [0,0,0,1]]\n  time_offset: 0.0\n"
        "  update_rate: 250.0\n  gyroscope_noise_density: 1e-4\n  gyroscope_random_walk: 2e-5\n"
        "  accelerometer_noise_density: 3e-3\n  accelerometer_random_walk: 4e-4\n");
  const RigCalibration both = read((folder_ / "camchain-imucam-a.yaml").string());
  ExpectNoise(both);
  EXPECT_EQ(both.imu->rate_hz, 250.0);
  EXPECT_EQ(both.imu->time_offset_s, -0.02);

  Write("kalibr_imu_chain.yaml", "imu0:\n  update_rate: 400.0\n");
  EXPECT_EQ(read(Write("kalibr_imucam_chain.yaml", shifted)).imu->rate_hz, 400.0) << "OpenVINS";
  EXPECT_FALSE(Read("camchain.yaml").imu) << "cameras without an IMU";
  EXPECT_TRUE(notes_.empty());
}

TEST_F(ForeignImu, ShiftBeyondASecondLeavesTheCameras) {
  const std::string shifted = Replaced(RigCalled("openvins.yaml").files.front().text, "  camera_model: pinhole\n",
                                       "  camera_model: pinhole\n  timeshift_cam_imu: 20\n");
  const std::string path = Write("chain.yaml", shifted);
  EXPECT_FALSE(ReadCalibration({path}, kSize, &notes_).imu);
  EXPECT_THAT(notes_.warnings, ElementsAre(AllOf(HasSubstr("the inertial sensor is not used: "),
                                                 HasSubstr("timeshift_cam_imu = 20 is not within -1 to 1"))));
  EXPECT_THAT(ErrorOf([&] { ReadCamchainImu(path); }), HasSubstr("timeshift_cam_imu = 20"));
}

TEST_F(ForeignImu, OrbSlam) {
  // Sensor from camera: a quarter turn about z, and the camera at (1, 2, 3) in the sensor.
  const std::string pose =
      ": !!opencv-matrix\n  rows: 4\n  cols: 4\n  dt: f\n"
      "  data: [0, -1, 0, 1, 1, 0, 0, 2, 0, 0, 1, 3, 0, 0, 0, 1]\n";
  const std::string noise =
      "IMU.NoiseGyro: 1e-4\nIMU.GyroWalk: 2e-5\nIMU.NoiseAcc: 3e-3\nIMU.AccWalk: 4e-4\n"
      "IMU.Frequency: 200.0\n";
  for (const auto& [file, key] : {std::pair("orb_slam3.yaml", "IMU.T_b_c1"), std::pair("orb_slam2.yaml", "Tbc")}) {
    const RigCalibration rig = Read(file, key + pose + noise);
    ExpectNoise(rig);
    EXPECT_EQ(rig.imu->rate_hz, 200.0);
    // The sensor's x axis, and its origin, in the camera, which is the body here.
    EXPECT_LT((rig.imu->T_b_imu.R() * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0, -1, 0)).norm(), 1e-12) << file;
    EXPECT_LT((rig.imu->T_b_imu.translation() - Eigen::Vector3d(-2, 1, -3)).norm(), 1e-12) << file;
    EXPECT_FALSE(Read(file).imu) << file;
  }
  Read("orb_slam3.yaml", "IMU.T_b_c1" + pose);
  ImuParts in_mm = ReadForeignImu({(folder_ / "orb_slam3.yaml").string()}, 1e-3, &imu_notes_);
  EXPECT_NEAR(in_mm.T_c_imu->translation().x(), -2e-3, 1e-15);
}

TEST_F(ForeignImu, VinsFusion) {
  const RigCalibration rig = Read("vins.yaml", "\nacc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 1e-4\ntd: -0.03\n");
  ExpectBody(rig);
  EXPECT_EQ(rig.imu->time_offset_s, 0.03) << "image clock + td = clock of the sensor";
  EXPECT_FALSE(parts_.noise) << "per sample";
  EXPECT_THAT(imu_notes_.remarks, ElementsAre(HasSubstr("noises of VINS-Fusion are per sample")));
  Write("vins.yaml", Replaced(RigCalled("vins.yaml").files.front().text, "imu: 1", "imu: 0"));
  EXPECT_FALSE(ReadCalibration({(folder_ / "vins.yaml").string()}, kSize).imu);
}

TEST_F(ForeignImu, Basalt) {
  const std::string text =
      Replaced(RigCalled("basalt.json").files.front().text, "\"imu_update_rate\"",
               "\"gyro_noise_std\": [1e-5, 1e-4, 5e-5], \"gyro_bias_std\": [2e-5, 2e-5, 2e-5],\n"
               "\"accel_noise_std\": [3e-3, 1e-3, 1e-3], \"accel_bias_std\": [4e-4, 4e-4, 4e-4],\n"
               "\"cam_time_offset_ns\": 5000000, \"imu_update_rate\"");
  const RigCalibration rig = ReadCalibration({Write("basalt.json", text)}, kSize);
  ExpectBody(rig);
  ExpectNoise(rig);
  EXPECT_EQ(rig.imu->rate_hz, 200.0);
  EXPECT_NEAR(rig.imu->time_offset_s, -0.005, 1e-15) << "added to the time of an image";
}

TEST_F(ForeignImu, Okvis) {
  const std::string noise = "  sigma_g_c: 1e-4\n  sigma_a_c: 3e-3\n  sigma_gw_c: 2e-5\n  sigma_aw_c: 4e-4\n";
  const RigCalibration first = Read("okvis.yaml", "imu_params:\n  imu_rate: 200\n" + noise + "imageDelay: 0.004\n");
  ExpectBody(first);
  ExpectNoise(first);
  EXPECT_EQ(first.imu->rate_hz, 200.0);
  EXPECT_EQ(first.imu->time_offset_s, 0.004) << "subtracted from the time of an image";
  const RigCalibration second =
      Read("okvis.yaml", "imu_parameters:\n  use: true\n" + noise + "camera_parameters:\n  image_delay: -0.004\n");
  ExpectNoise(second);
  EXPECT_EQ(second.imu->time_offset_s, -0.004);
  EXPECT_FALSE(Read("okvis.yaml", "imu_parameters:\n  use: false\n" + noise).imu);
  EXPECT_FALSE(Read("okvis.yaml").imu);
}

TEST_F(ForeignImu, Svo) {
  const RigCalibration rig = Read("svo.yaml",
                                  "imu_params:\n  delay_imu_cam: 0.004\n  sigma_omega_c: 1e-4\n"
                                  "  sigma_acc_c: 3e-3\n  sigma_omega_bias_c: 2e-5\n"
                                  "  sigma_acc_bias_c: 4e-4\n  imu_rate: 200\n");
  ExpectBody(rig);
  ExpectNoise(rig);
  EXPECT_EQ(rig.imu->time_offset_s, 0.004) << "subtracted from the time of an image";
  EXPECT_FALSE(Read("svo.yaml").imu);
}

TEST_F(ForeignImu, AirSlam) {
  const RigCalibration rig = Read("airslam.yaml", "\n" + std::string(kNoise) + "g_value: 9.81007\n");
  ExpectBody(rig);
  ExpectNoise(rig);
  EXPECT_EQ(rig.imu->rate_hz, 200.0);
}

TEST_F(ForeignImu, KimeraHasAFileOfItsOwn) {
  EXPECT_FALSE(Read("LeftCameraParams.yaml").imu);
  Write("ImuParams.yaml",
        "T_BS:\n  cols: 4\n  rows: 4\n  data: [1,0,0,0.1, 0,1,0,0, 0,0,1,0, 0,0,0,1]\nrate_hz: 200\n" +
            std::string(kNoise) + "imu_time_shift: 0.01\nn_gravity: [0.0, 0.0, -9.81]\n");
  const RigCalibration rig = Read("LeftCameraParams.yaml");
  ExpectNoise(rig);
  EXPECT_EQ(rig.imu->T_b_imu.translation().x(), 0.1);
  EXPECT_EQ(rig.imu->time_offset_s, -0.01) << "t_imu = t_cam + shift";
}

TEST_F(ForeignImu, OurFileAddsToThoseItNames) {
  Read("svo.yaml", "imu_params:\n  delay_imu_cam: 0.004\n  imu_rate: 200\n");
  const std::string ours = Write("camera.yaml", "from: svo.yaml\nimu: {time_offset_s: 0.001}\n");
  const RigCalibration rig = ReadCameraFile(ours, kSize);
  ASSERT_TRUE(rig.imu);
  EXPECT_EQ(rig.imu->rate_hz, 200.0);
  EXPECT_EQ(rig.imu->time_offset_s, 0.001) << "our key is decisive";
}

TEST_F(ForeignImu, CamerasAloneStateNothing) {
  for (const test::ForeignRig& rig : test::ForeignRigs()) {
    const std::vector<std::string> paths = WriteAll(rig);
    Notes notes;
    const ImuParts parts = ReadForeignImu(paths, std::nullopt, &notes);
    const RigCalibration read = ReadCalibration(paths, kSize, &notes);
    EXPECT_EQ(read.imu.has_value(), parts.is_stated) << rig.files.front().name;
    if (!read.imu) continue;
    const RigCalibration back = ReadCalibration({Write("ours.yaml", CameraFileText(read))}, kSize);
    ASSERT_TRUE(back.imu) << rig.files.front().name;
    EXPECT_TRUE(back.imu->T_b_imu.matrix().isApprox(read.imu->T_b_imu.matrix(), 1e-12)) << rig.files.front().name;
  }
}

}  // namespace
}  // namespace plslam
