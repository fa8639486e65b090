// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "core/datasets/camera_file.h"
#include "core/datasets/open_dataset.h"
#include "tests/support/data_folder.h"
#include "tests/support/python.h"
#include "tests/support/shell.h"
#include "tests/unit/odometry_library/header_in_c.h"
#include "tools/odometry_library/plslam_odometry.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kWorld = "synthetic:room?frames=12&size=376x240";

plslam_image ImageOf(const cv::Mat& image) {
  return {image.data, static_cast<int64_t>(image.step), image.cols, image.rows, image.type() == CV_8UC1 ? 8 : 16};
}

/// A short world, its calibration in a file, and an odometry of the library.
class OdometryLibrary : public testing::Test {
 protected:
  OdometryLibrary() {
    std::ofstream(folder_.Path("camera.yaml")) << CameraFileText(dataset_->rig());
    odometry_ = Create(folder_.Path("camera.yaml"));
    EXPECT_NE(odometry_, nullptr) << error_;
  }
  ~OdometryLibrary() override { plslam_odometry_destroy(odometry_); }

  plslam_odometry* Create(const std::string& calibration, const char* options = nullptr) {
    char error[300] = "";
    plslam_odometry* odometry = plslam_odometry_create(calibration.c_str(), 0, 0, options, error, sizeof error);
    error_ = error;
    return odometry;
  }

  int Track(const StereoImages& images, plslam_pose* pose) {
    const plslam_image left = ImageOf(images.left), right = ImageOf(images.right);
    return plslam_odometry_track(odometry_, images.t_ns, &left, &right, pose);
  }

  std::vector<plslam_pose> TrackAll(const Dataset& dataset) {
    std::vector<plslam_pose> poses;
    for (int i = 0; i < dataset.size(); ++i) {
      EXPECT_EQ(Track(dataset.Read(i), &poses.emplace_back()), 0) << plslam_odometry_error(odometry_);
    }
    return poses;
  }

  std::string error() const { return plslam_odometry_error(odometry_); }

  std::unique_ptr<Dataset> dataset_ = OpenDataset(kWorld, "");
  ScratchFolder folder_;
  plslam_odometry* odometry_ = nullptr;
  std::string error_;
};

TEST_F(OdometryLibrary, PosesAreThoseOfTheTracker) {
  const std::vector<plslam_pose> poses = TrackAll(*dataset_);
  const vo::VoOptions options;
  vo::StereoFrontEnd front_end(dataset_->rig(), options);
  vo::Odometry odometry(front_end.camera(), options, front_end.shutter());
  for (int i = 0; i < dataset_->size(); ++i) {
    const StereoImages images = dataset_->Read(i);
    vo::StageTimer timer;
    const vo::OdometryResult result = odometry.Track(images.t_ns, odometry.SeePair(front_end, images, timer));
    const plslam_pose& pose = poses[static_cast<size_t>(i)];
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> T = result.T_odom_c.matrix();
    const Eigen::Matrix<double, 6, 6, Eigen::RowMajor> covariance = result.covariance;
    EXPECT_EQ(std::memcmp(pose.T_odom_c, T.data(), sizeof pose.T_odom_c), 0) << i;
    EXPECT_EQ(std::memcmp(pose.covariance, covariance.data(), sizeof pose.covariance), 0) << i;
    EXPECT_EQ(pose.state, static_cast<int32_t>(result.state)) << i;
    EXPECT_EQ(pose.is_keyframe, result.keyframe ? 1 : 0) << i;
    EXPECT_EQ(pose.tracked_points, result.n_tracked_points) << i;
  }
  EXPECT_EQ(poses.back().state, PLSLAM_TRACKING);
  EXPECT_GT(poses.back().tracked_lines, 5);
}

TEST_F(OdometryLibrary, RecordedPairsReproduceTheRun) {
  const std::string record = folder_.Path("recorded");
  ASSERT_EQ(plslam_odometry_record(odometry_, record.c_str()), 0) << error();
  const std::vector<plslam_pose> poses = TrackAll(*dataset_);
  EXPECT_EQ(plslam_odometry_record(odometry_, record.c_str()), -1);
  EXPECT_THAT(error(), HasSubstr("recorded: is not empty; give a new folder"));
  const std::unique_ptr<Dataset> recorded = OpenDataset(record, "");
  ASSERT_EQ(recorded->size(), dataset_->size());
  plslam_odometry_destroy(odometry_);
  odometry_ = Create(record + "/camera.yaml");
  const std::vector<plslam_pose> again = TrackAll(*recorded);
  EXPECT_EQ(std::memcmp(poses.data(), again.data(), poses.size() * sizeof(plslam_pose)), 0);
}

TEST_F(OdometryLibrary, WrongArgumentsAreNamedAndHarmless) {
  EXPECT_EQ(Create(folder_.Path("none.yaml")), nullptr);
  EXPECT_THAT(error_, HasSubstr("none.yaml"));
  EXPECT_EQ(Create(folder_.Path("camera.yaml"), "vo: {tracking: {min_inlier: 3}}"), nullptr);
  EXPECT_THAT(error_, HasSubstr("the nearest known one is 'vo.tracking.min_inliers'"));
  EXPECT_EQ(Create(folder_.Path("camera.yaml"), "mapping: {max_keyframes: 30}"), nullptr);
  EXPECT_EQ(plslam_odometry_create(nullptr, 0, 0, nullptr, nullptr, 0), nullptr);
  plslam_odometry_destroy(nullptr);
  EXPECT_THAT(plslam_odometry_error(nullptr), HasSubstr("returned NULL"));

  const StereoImages images = dataset_->Read(0);
  const plslam_image left = ImageOf(images.left), right = ImageOf(images.right);
  plslam_pose pose;
  const auto fails_with = [&](const plslam_image* a, const plslam_image* b, const char* part) {
    EXPECT_EQ(plslam_odometry_track(odometry_, 5, a, b, &pose), -1);
    EXPECT_THAT(error(), HasSubstr(part));
  };
  fails_with(nullptr, &right, "the left image has no pixels");
  plslam_image wrong = right;
  wrong.bits = 24;
  fails_with(&left, &wrong, "the right image has 24 bits; it must have 8, or 16 (depths)");
  wrong = right;
  wrong.row_bytes = 10;
  fails_with(&left, &wrong, "and 10 bytes a row, which cannot be");
  wrong = right;
  wrong.height_px = 100;
  fails_with(&left, &wrong, "100");
  EXPECT_EQ(plslam_odometry_track(odometry_, 5, &left, &right, nullptr), -1);
  ASSERT_EQ(plslam_odometry_track(odometry_, 5, &left, &right, &pose), 0) << error();
  EXPECT_EQ(pose.is_keyframe, 1);
  fails_with(&left, &right, "the pair of 5 ns is not later than the previous one, of 5 ns");
}

TEST_F(OdometryLibrary, ProgramInCTracks) {
  const StereoImages images = dataset_->Read(0);
  ASSERT_TRUE(images.left.isContinuous() && images.right.isContinuous());
  EXPECT_EQ(TrackOnePairInC(folder_.Path("camera.yaml").c_str(), images.left.data, images.right.data,
                            images.left.cols, images.left.rows),
            1);
}

/// The example computes the path of a camera that moves by 2 cm a frame.
TEST_F(OdometryLibrary, ExampleInPythonTracks) {
  const std::string python = PythonWithNumpy();
  if (python.empty()) GTEST_SKIP() << "no Python with numpy here";
  const ShellResult result = Shell(
      folder_,
      fmt::format("PYTHONDONTWRITEBYTECODE=1 PYTHONPATH='{}' {} '{}/tools/python/examples/compute_odometry.py' '{}'",
                  PLSLAM_PYTHON_FOLDER, python, SourceFolder().string(), folder_.Path("from_python")));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const size_t last = result.out.find("39 tracking [");
  ASSERT_NE(last, std::string::npos) << result.out;
  EXPECT_NEAR(std::stod(result.out.substr(last + 13)), 39 * 0.02, 0.02) << result.out;
  EXPECT_EQ(OpenDataset(folder_.Path("from_python"), "")->size(), 40);
}

}  // namespace
}  // namespace plslam::test
