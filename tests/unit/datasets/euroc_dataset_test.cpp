// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/euroc_dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/support/data_folder.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;
using test::ErrorOf;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class EurocDataset : public testing::Test {
 protected:
  EurocDataset() { test::MakeEurocFolder(folder_); }
  std::string OpenError() const {
    return ErrorOf([this] { OpenEurocDataset(folder_.string()); });
  }
  std::string At(const std::string& name) const { return (mav_ / name).string(); }

  test::TemporaryFolder temporary_;
  const fs::path folder_ = temporary_.path() / "MH_01_easy";
  const fs::path mav_ = folder_ / "mav0";
  const fs::path truth_ = mav_ / "state_groundtruth_estimate0" / "data.csv";
};

TEST_F(EurocDataset, HandMadeFolder) {
  ASSERT_TRUE(LooksLikeEuroc(folder_.string()));
  const auto dataset = OpenEurocDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->t_ns(0), 1403636584763555584);
  const RigCalibration& rig = dataset->rig();
  EXPECT_EQ(rig.left.model, "radtan");
  EXPECT_THAT(rig.left.distortion, ElementsAre(-0.28, 0.07, 0.0002, 1.8e-05));
  EXPECT_EQ(rig.left.fy_px, 41.0);
  EXPECT_NEAR(rig.baseline_m, 0.1, 1e-12);
  EXPECT_NEAR(rig.rate_hz, 10.0, 1e-9);
  EXPECT_EQ(dataset->Read(1).right.at<uint8_t>(5, 7), test::TinyPixel(1, 1, 7, 5));
  EXPECT_TRUE(dataset->Notes().empty());
}

constexpr const char* kSensorYaml =
    "sensor_type: imu\n"
    "T_BS:\n  cols: 4\n  rows: 4\n  data: [1, 0, 0, 0.1, 0, 1, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1]\n"
    "rate_hz: 200\ngyroscope_noise_density: 1.7e-4\ngyroscope_random_walk: 2.0e-5\n"
    "accelerometer_noise_density: 2.0e-3\naccelerometer_random_walk: 3.0e-3\n";

TEST_F(EurocDataset, InertialSensor) {
  fs::create_directories(mav_ / "imu0");
  test::WriteText(mav_ / "imu0" / "data.csv",
                  "#timestamp [ns],w_x,w_y,w_z,a_x,a_y,a_z\n"
                  "1403636584763555584,0.1,0.2,0.3,1,2,9.8\n"
                  "1403636584768555584,0.4,0.5,0.6,3,4,9.7\n"
                  "1403636584768555584,0.4,0.5,0.6,3,4,9.7\n");
  const auto uncalibrated = OpenEurocDataset(folder_.string());
  EXPECT_FALSE(uncalibrated->rig().imu);
  EXPECT_TRUE(uncalibrated->ImuSamples().empty());
  EXPECT_THAT(uncalibrated->Notes().warnings, ElementsAre(HasSubstr("its calibration is missing: write")));

  test::WriteText(mav_ / "imu0" / "sensor.yaml", kSensorYaml);
  const auto dataset = OpenEurocDataset(folder_.string());
  ASSERT_TRUE(dataset->rig().imu);
  EXPECT_EQ(dataset->rig().imu->T_b_imu.translation(), Eigen::Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(dataset->rig().imu->noise.accelerometer_walk_m_s3_sqrt_hz, 3e-3);
  ASSERT_EQ(dataset->ImuSamples().size(), 2U);
  EXPECT_EQ(dataset->ImuSamples()[1],
            (ImuSample{1403636584768555584, Eigen::Vector3d(0.4, 0.5, 0.6), Eigen::Vector3d(3.0, 4.0, 9.7)}));
  EXPECT_THAT(dataset->Notes().warnings, ElementsAre(HasSubstr("1 samples are not used")));

  test::ReplaceText(mav_ / "imu0" / "sensor.yaml", "2.0e-3", "-1");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr("sensor.yaml:"), HasSubstr("accelerometer_noise_density = -1")));
}

TEST_F(EurocDataset, MavFolderItselfIsAccepted) {
  EXPECT_TRUE(LooksLikeEuroc(mav_.string()));
  EXPECT_EQ(OpenEurocDataset(mav_.string())->size(), 3);
}

TEST_F(EurocDataset, GroundTruthInTheLeftCameraIsInterpolated) {
  // The body moves 0.1 m along x every 50 ms; frames lie on rows 1 and 3, and half way after shifting the rows.
  const auto on_rows = OpenEurocDataset(folder_.string());
  // T_b_l moves the camera by (0, 0, 0.5) and the body is not turned.
  EXPECT_TRUE(on_rows->GroundTruth(1)->translation().isApprox(Eigen::Vector3d(0.3, 0.0, 1.5), 1e-9));
  test::WriteText(truth_,
                  "1403636584713555584,0,0,1,1,0,0,0\n"
                  "1403636584813555584,1,0,1,0.70710678,0,0,0.70710678\n");
  const auto between = OpenEurocDataset(folder_.string());
  ASSERT_TRUE(between->GroundTruth(0));
  EXPECT_TRUE(between->GroundTruth(0)->translation().isApprox(Eigen::Vector3d(0.5, 0.0, 1.5), 1e-9));
  // Half of the turn of 90 degrees about z, after the 90 degrees of T_b_l.
  const Eigen::Vector3d x = between->GroundTruth(0)->R().col(0);
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d(-std::sqrt(0.5), std::sqrt(0.5), 0.0), 1e-6)) << x.transpose();
  EXPECT_FALSE(between->GroundTruth(1)) << "nothing is extrapolated";
}

TEST_F(EurocDataset, SeventeenColumnsAndGapsInGroundTruth) {
  const std::string rest = ",0,0,0,0,0,0,0,0,0\n";
  test::WriteText(truth_, "1403636584713555584,0,0,1,1,0,0,0" + rest + "1403636584913555584,1,0,1,1,0,0,0" + rest);
  const auto dataset = OpenEurocDataset(folder_.string());
  EXPECT_FALSE(dataset->GroundTruth(0)) << "the rows are 0.2 s apart";
  EXPECT_FALSE(dataset->GroundTruth(2));
}

TEST_F(EurocDataset, GroundTruthWithHeaderOnlyOrAbsent) {
  test::WriteText(truth_, "#timestamp [ns],p_RS_R_x [m]\n");
  EXPECT_FALSE(OpenEurocDataset(folder_.string())->GroundTruth(0));
  fs::remove(truth_);
  EXPECT_FALSE(OpenEurocDataset(folder_.string())->GroundTruth(0));
}

TEST_F(EurocDataset, UnpairedImagesAreSkippedAndReported) {
  test::WriteText(mav_ / "cam1" / "data.csv",
                  "1403636584763555584,1403636584763555584.png\n"
                  "1403636584800000000,nowhere.png\n"
                  "1403636584963655584,1403636584963555584.png\n");
  const auto dataset = OpenEurocDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->t_ns(1), 1403636584963555584) << "0.1 ms apart is the same moment";
  EXPECT_EQ(dataset->Read(1).right.at<uint8_t>(5, 7), test::TinyPixel(2, 1, 7, 5));
  EXPECT_THAT(dataset->Notes().remarks, ElementsAre(HasSubstr("differ by up to 0.100 ms")));
  EXPECT_THAT(dataset->Notes().warnings, ElementsAre("1 of 3 images of cam0 has no partner in time and is skipped",
                                                     "1 of 3 images of cam1 has no partner in time and is skipped"));
  test::WriteText(mav_ / "cam1" / "data.csv", "1,1403636584763555584.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("cam1/data.csv")),
                                 HasSubstr("no image is within half a frame of an image of cam0")));
}

TEST_F(EurocDataset, CamerasTwoMillisecondsApart) {
  test::WriteText(mav_ / "cam1" / "data.csv",
                  "1403636584765555584,1403636584763555584.png\n"
                  "1403636584865555584,1403636584863555584.png\n"
                  "1403636584965655584,1403636584963555584.png\n");
  const auto dataset = OpenEurocDataset(folder_.string());
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->t_ns(2), 1403636584963555584);
  EXPECT_EQ(dataset->Read(2).right.at<uint8_t>(5, 7), test::TinyPixel(2, 1, 7, 5));
  EXPECT_TRUE(dataset->Notes().warnings.empty());
  EXPECT_THAT(dataset->Notes().remarks,
              ElementsAre("times of cam0 and cam1 differ by up to 2.100 ms: the nearest ones are pairs"));
}

TEST_F(EurocDataset, JpegImagesOfTheList) {
  test::TemporaryFolder other;
  test::MakeEurocFolder(other.path(), ".jpg");
  const StereoImages images = OpenEurocDataset(other.path().string())->Read(0);
  EXPECT_EQ(images.left.type(), CV_8UC1);
  EXPECT_EQ(images.left.size(), cv::Size(test::kTinyWidth_px, test::kTinyHeight_px));
}

TEST_F(EurocDataset, EquidistantModel) {
  for (const char* camera : {"cam0", "cam1"}) {
    test::ReplaceText(mav_ / camera / "sensor.yaml", "radial-tangential", "equidistant");
  }
  EXPECT_EQ(OpenEurocDataset(folder_.string())->rig().right.model, "equidistant");
}

TEST_F(EurocDataset, MotionCaptureTruthWithoutAnEstimate) {
  const fs::path mocap = mav_ / "mocap0" / "data.csv";
  test::WriteText(
      mocap,
      "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []\n"
      "1403636584763555584, 7, 0, 1, 1, 0, 0, 0\n1403636584863555584, 8, 0, 1, 1, 0, 0, 0\n");
  EXPECT_NEAR(OpenEurocDataset(folder_.string())->GroundTruth(0)->translation().x(), 0.1, 1e-9);
  fs::remove(truth_);
  const auto dataset = OpenEurocDataset(folder_.string());
  ASSERT_TRUE(dataset->GroundTruth(0));
  EXPECT_TRUE(dataset->GroundTruth(0)->translation().isApprox(Eigen::Vector3d(7.0, 0.0, 1.5), 1e-9));
}

// As Kalibr writes it for TUM-VI, with the two cameras of the hand-made folder.
std::string Camchain(const std::string& right_extrinsics) {
  const std::string lens = R"(
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [0.003, 0.0007, -0.002, 0.0002]
  distortion_model: equidistant
  intrinsics: [40.0, 41.0, 24.0, 16.0]
  resolution: [48, 32]
  rostopic: /cam/image_raw
)";
  return R"(cam0:
  T_cam_imu:
  - [0.0, 1.0, 0.0, 0.0]
  - [-1.0, 0.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, -0.5]
  - [0.0, 0.0, 0.0, 1.0])" +
         lens + "cam1:\n" + right_extrinsics + lens;
}

TEST_F(EurocDataset, CamchainBesideTheFolderReplacesSensorFiles) {
  const fs::path chain = folder_ / "dso" / "camchain.yaml";
  const auto expected = OpenEurocDataset(folder_.string())->rig();
  for (const char* camera : {"cam0", "cam1"}) fs::remove(mav_ / camera / "sensor.yaml");
  for (const char* right : {"  T_cam_imu: [[0, 1, 0, -0.1], [-1, 0, 0, 0], [0, 0, 1, -0.5], [0, 0, 0, 1]]",
                            "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"}) {
    test::WriteText(chain, Camchain(right));
    for (const fs::path& folder : {folder_, mav_ / ""}) {
      const RigCalibration rig = OpenEurocDataset(folder.string())->rig();
      EXPECT_EQ(rig.left.model, "equidistant");
      EXPECT_THAT(rig.right.distortion, ElementsAre(0.003, 0.0007, -0.002, 0.0002));
      EXPECT_TRUE(rig.left.T_b_cam.matrix().isApprox(expected.left.T_b_cam.matrix(), 1e-9));
      EXPECT_TRUE(rig.right.T_b_cam.matrix().isApprox(expected.right.T_b_cam.matrix(), 1e-9));
      EXPECT_NEAR(rig.baseline_m, 0.1, 1e-9);
    }
  }
  test::WriteText(chain, Camchain("  T_cam_imu: [[0, 1, 0], [-1, 0, 0, 0], [0, 0, 1, -0.5], [0, 0, 0, 1]]"));
  EXPECT_THAT(OpenError(), HasSubstr(chain.string() + ":15: T_cam_imu must have rows of 4 numbers"));
  test::WriteText(chain, Camchain("  T_cam_imu: 7"));
  EXPECT_THAT(OpenError(), HasSubstr(chain.string() + ":15: T_cam_imu must be a list"));
  fs::remove(chain);
  EXPECT_THAT(OpenError(), HasSubstr(At("cam0/sensor.yaml")));
}

TEST_F(EurocDataset, SensorOfTumViIsInKalibrsFiles) {
  for (const char* camera : {"cam0", "cam1"}) fs::remove(mav_ / camera / "sensor.yaml");
  const std::string right = "  T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]";
  test::WriteText(folder_ / "dso" / "camchain.yaml", Camchain(right));
  fs::create_directories(mav_ / "imu0");
  test::WriteText(mav_ / "imu0" / "data.csv",
                  "1403636584763555584,0.1,0.2,0.3,1,2,9.8\n1403636584768555584,0.1,0.2,0.3,1,2,9.8\n");
  const std::string noise =
      "gyroscope_noise_density: 0.00016\ngyroscope_random_walk: 0.000022\n"
      "accelerometer_noise_density: 0.0028\naccelerometer_random_walk: 0.00086\n";
  test::WriteText(folder_ / "dso" / "imu_config.yaml", noise + "rostopic: /imu0\nupdate_rate: 200.0\nelse: 1\n");
  const auto dataset = OpenEurocDataset(folder_.string());
  ASSERT_TRUE(dataset->rig().imu);
  EXPECT_TRUE(dataset->rig().imu->T_b_imu.matrix().isIdentity()) << "the body of the chain";
  EXPECT_EQ(dataset->rig().imu->rate_hz, 200.0);
  EXPECT_EQ(dataset->rig().imu->noise.accelerometer_m_s2_sqrt_hz, 0.0028);
  EXPECT_EQ(dataset->ImuSamples().size(), 2U);
  EXPECT_TRUE(dataset->Notes().empty());
  test::ReplaceText(folder_ / "dso" / "camchain.yaml", "cam0:\n", "cam0:\n  timeshift_cam_imu: 0.003\n");
  const auto shifted = OpenEurocDataset(folder_.string());
  ASSERT_TRUE(shifted->rig().imu);
  EXPECT_EQ(shifted->rig().imu->time_offset_s, -0.003);
}

TEST_F(EurocDataset, HeadersWithoutAMarkAndByteOrderMarks) {
  for (const fs::path& list : {mav_ / "cam0" / "data.csv", mav_ / "cam1" / "data.csv", truth_}) {
    test::ReplaceText(list, "#timestamp", "\xEF\xBB\xBFtimestamp");
  }
  const auto dataset = OpenEurocDataset(folder_.string());
  EXPECT_EQ(dataset->size(), 3);
  EXPECT_TRUE(dataset->GroundTruth(0));
}

TEST_F(EurocDataset, BadSensorFilesAreNamedWithTheirLine) {
  const fs::path sensor = mav_ / "cam0" / "sensor.yaml";
  const std::string good = test::ReadText(sensor);
  struct Row {
    const char* from;
    const char* to;
    const char* line;
    const char* what;
  };
  for (const Row& row : {Row{"[40.0, 41.0,", "[0.0, 41.0,", ":13: intrinsics", "focal length fx = 0"},
                         Row{"[40.0, 41.0,", "[.nan, 41.0,", ":13: intrinsics", "'.nan' is not a finite number"},
                         Row{"[40.0, 41.0,", "[41.0,", ":13: intrinsics", "has 3 numbers, not 4"},
                         Row{"24.0, 16.0]", "24e9, 16.0]", ":13: intrinsics", "principal point cx"},
                         Row{"[48, 32]", "[48.5, 32]", ":11: resolution", "48.5"},
                         Row{"[48, 32]", "[48, 1e30]", ":11: resolution", "1e+30"},
                         Row{"[48, 32]", "[4, 4]", ":11: resolution", "4 x 4"},
                         Row{"[0.0, -1.0, 0.0, 0.0,", "[0.0, -2.0, 0.0, 0.0,", ":3: T_BS", "is not a rotation"},
                         Row{"[0.0, -1.0, 0.0, 0.0,", "[", ":3: T_BS", "12 numbers"},
                         Row{"0.0, 0.0, 0.0, 1.0]", "0.0, 0.0, 0.0, 2.0]", ":3: T_BS", "last row"},
                         Row{"radial-tangential", "omni", ":14: distortion_model", "'omni'"},
                         Row{"camera_model: pinhole", "camera_model: mei", ":12: camera_model", "'mei'"},
                         Row{", 1.8e-05]", "]", ":15: distortion_coefficients", "has 3 numbers"},
                         Row{"intrinsics:", "intrinsic:", ":2: intrinsics", "is missing"},
                         Row{"rate_hz: 20", "rate_hz: [20", ":11: ", ""},
                         Row{"rate_hz: 20", "resolution: 20", ":11: key 'resolution'", "is repeated"}}) {
    test::WriteText(sensor, good);
    test::ReplaceText(sensor, row.from, row.to);
    const std::string error = OpenError();
    const bool twelve = std::string(row.what) == "12 numbers";  // 12 numbers are a transform too, but not this one
    EXPECT_THAT(error, HasSubstr(At("cam0/sensor.yaml") + row.line)) << row.to;
    EXPECT_THAT(error, HasSubstr(twelve ? "is not a rotation" : row.what)) << row.to;
  }
  test::WriteText(sensor, "");
  EXPECT_THAT(OpenError(), HasSubstr("the calibration is empty"));
  test::WriteText(sensor, std::string(1'100'000, ' '));
  EXPECT_THAT(OpenError(), HasSubstr("more than 1000000 bytes"));
  fs::remove(sensor);
  EXPECT_THAT(OpenError(), HasSubstr("the calibration cannot be read: No such file or directory"));
}

TEST_F(EurocDataset, CamerasOfDifferentSizeOrExchanged) {
  test::ReplaceText(mav_ / "cam1" / "sensor.yaml", "[48, 32]", "[48, 33]");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("cam1/sensor.yaml")), HasSubstr("48 x 32"), HasSubstr("48 x 33")));
  test::ReplaceText(mav_ / "cam1" / "sensor.yaml", "[48, 33]", "[48, 32]");
  fs::rename(mav_ / "cam0", mav_ / "cam2");
  fs::rename(mav_ / "cam1", mav_ / "cam0");
  fs::rename(mav_ / "cam2", mav_ / "cam1");
  EXPECT_THAT(OpenError(), HasSubstr("must be to the right of the left one"));
}

TEST_F(EurocDataset, BadListsAreNamedWithTheirLine) {
  const fs::path list = mav_ / "cam0" / "data.csv";
  test::WriteText(list, "#t,f\n200,a.png\n100,b.png\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("cam0/data.csv") + ":3: time 100 ns is not after the 200 ns"));
  test::WriteText(list, "#t,f\n200,a.png,c\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("cam0/data.csv") + ":2: 3 columns instead of 2"));
  test::WriteText(list, "#t,f\n200,../../secret.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("cam0/data.csv") + ":2: "), HasSubstr("leaves the folder")));
  test::WriteText(list, "#t,f\n99999999999999999999,a.png\n");
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("cam0/data.csv") + ":2: "), HasSubstr("too large")));
  test::WriteText(list, "#t,f\n");
  EXPECT_THAT(OpenError(), HasSubstr(At("cam0/data.csv") + ": lists no images"));
}

TEST_F(EurocDataset, BadRowsOfTheTruthAreSkipped) {
  const std::string truth = test::ReadText(truth_);
  const auto before = OpenEurocDataset(mav_.parent_path().string());
  const auto note = [&](const std::string& row) {
    test::WriteText(truth_, truth + row + "\n");
    const auto dataset = OpenEurocDataset(mav_.parent_path().string());
    EXPECT_EQ(dataset->GroundTruth(0).has_value(), before->GroundTruth(0).has_value());
    EXPECT_EQ(dataset->size(), before->size());
    return dataset->Notes().warnings.empty() ? "" : dataset->Notes().warnings.back();
  };
  const std::string last = truth_.string() + ":" + std::to_string(std::count(truth.begin(), truth.end(), '\n') + 1);
  EXPECT_THAT(note("1403636584713555584,0,0,1,1,0,0"), AllOf(HasSubstr(last + ": 7 columns"), HasSubstr("; 1 of ")));
  EXPECT_THAT(note("1403636584713555584,0,0,1,nan,0,0,0"),
              AllOf(HasSubstr(last + ": 'nan'"), HasSubstr(" rows is skipped")));
  EXPECT_THAT(note("1403636584713555584,0,0,1,0,0,0,0"), HasSubstr(last + ": the quaternion has norm 0"));
  EXPECT_THAT(note("100,0,0,1,1,0,0,0"), HasSubstr("time 100 ns is not after the "));
}

TEST_F(EurocDataset, TruthWithoutPosesOpens) {
  const std::string folder = mav_.parent_path().string();
  test::WriteText(truth_, "#h\n1,0,0,1,nan,0,0,0\n2,0,0,1,nan,0,0,0\n");
  EXPECT_THAT(OpenEurocDataset(folder)->Notes().warnings,
              testing::ElementsAre(AllOf(HasSubstr(truth_.string() + ":2: 'nan'"), HasSubstr("2 of 2 rows are"))));
  test::WriteText(truth_, "version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n");
  EXPECT_THAT(OpenEurocDataset(folder)->Notes().warnings, testing::ElementsAre(HasSubstr("is a pointer of Git LFS")));
}

TEST_F(EurocDataset, ImageOfAnotherSizeThanTheSensorFile) {
  for (const char* camera : {"cam0", "cam1"}) {
    test::ReplaceText(mav_ / camera / "sensor.yaml", "[48, 32]", "[64, 32]");
  }
  EXPECT_THAT(OpenError(), AllOf(HasSubstr(At("cam1/sensor.yaml")), HasSubstr("1403636584763555584.png"),
                                 HasSubstr("48 x 32"), HasSubstr("64 x 32")));
}

TEST_F(EurocDataset, RealSequences) {
  struct Row {
    const char* name;
    int n_frames;
    int n_truth;
    cv::Size size;
    const char* model;
    double baseline_m;
  };
  for (const Row& row : {Row{"euroc_MH_01_a", 58, 58, {752, 480}, "radtan", 0.110},
                         Row{"euroc_V1_01_sparse", 100, 99, {752, 480}, "radtan", 0.110},
                         Row{"euroc_V1_01_static", 8, 0, {752, 480}, "radtan", 0.110},
                         Row{"tumvi_room1_static", 4, 4, {512, 512}, "equidistant", 0.101}}) {
    PLSLAM_REQUIRE_DATA(real, row.name);
    const auto dataset = OpenEurocDataset(real.string());
    EXPECT_EQ(dataset->size(), row.n_frames) << row.name;
    int n_truth = 0;
    for (int i = 0; i < dataset->size(); ++i) n_truth += dataset->GroundTruth(i).has_value() ? 1 : 0;
    EXPECT_EQ(n_truth, row.n_truth) << row.name;
    EXPECT_EQ(dataset->Read(0).left.size(), row.size) << row.name;
    EXPECT_EQ(dataset->rig().left.model, row.model) << row.name;
    EXPECT_NEAR(dataset->rig().baseline_m, row.baseline_m, 1e-3) << row.name;
  }
}

}  // namespace
}  // namespace plslam
