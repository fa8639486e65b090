// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/geometry/distortion.h"
#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/dataset_matchers.h"
#include "tests/unit/datasets/foreign_files.h"

namespace plslam::test {

/// Writes the files of a rig, changed or not, into a temporary folder.
class ForeignCalibrationTest : public testing::Test {
 protected:
  static constexpr ImageSize kSize{672, 376};

  std::string Write(const std::string& name, const std::string& text) const {
    WriteText(folder_ / name, text);
    return (folder_ / name).string();
  }
  std::vector<std::string> WriteAll(const ForeignRig& rig) const {
    std::vector<std::string> paths;
    for (const ForeignFile& file : rig.files) paths.push_back(Write(file.name, file.text));
    for (const ForeignFile& file : rig.beside) Write(file.name, file.text);
    return paths;
  }
  static const ForeignRig& RigCalled(const std::string& name) {
    for (const ForeignRig& rig : ForeignRigs()) {
      if (rig.files.front().name == name) return rig;
    }
    throw std::runtime_error("no file " + name);
  }
  static std::string Replaced(std::string text, const std::string& from, const std::string& to) {
    const size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
  }

  TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

inline void ExpectLens(const CameraCalibration& camera, const std::vector<double>& intrinsics,
                       const std::vector<double>& distortion, const std::string& what) {
  EXPECT_EQ(camera.width_px, 672) << what;
  EXPECT_EQ(camera.height_px, 376) << what;
  EXPECT_DOUBLE_EQ(camera.fx_px, intrinsics[0]) << what;
  EXPECT_DOUBLE_EQ(camera.fy_px, intrinsics[1]) << what;
  EXPECT_DOUBLE_EQ(camera.cx_px, intrinsics[2]) << what;
  EXPECT_DOUBLE_EQ(camera.cy_px, intrinsics[3]) << what;
  CameraCalibration expected;
  expected.model = "radtan";
  expected.distortion = distortion;
  for (const Eigen::Vector2d& xy : {Eigen::Vector2d(0.5, -0.3), Eigen::Vector2d(-0.1, 0.4)}) {
    const auto seen = Distortion(camera).Distort(xy), wanted = Distortion(expected).Distort(xy);
    ASSERT_TRUE(seen && wanted) << what;
    EXPECT_LT((*seen - *wanted).norm(), 1e-12) << what;
  }
}

inline void ExpectTheRig(const RigCalibration& rig, const std::string& what) {
  ExpectLens(rig.left, {458.5, 457.25, 335.5, 188.75}, {-0.28, 0.07, 0.0002, -0.0001}, what);
  ExpectLens(rig.right, {459.5, 458.25, 337.25, 186.5}, {-0.27, 0.06, -0.0003, 0.0004}, what);
  const SE3 expected(Eigen::Quaterniond(0.99712, 0.0, 0.07584, 0.0), Eigen::Vector3d(0.12, 0.035, 0.0));
  const SE3 T_l_r = rig.left.T_b_cam.Inverse() * rig.right.T_b_cam;
  EXPECT_LT((T_l_r.matrix() - expected.matrix()).cwiseAbs().maxCoeff(), 1e-12) << what << "\n" << T_l_r.matrix();
  EXPECT_NEAR(rig.baseline_m, 0.125, 1e-12) << what;
}

}  // namespace plslam::test
