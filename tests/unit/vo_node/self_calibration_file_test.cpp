// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/self_calibration_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "core/bus/messages/convert.h"
#include "core/bus/transport/wire.h"
#include "plslam/camera_t.hpp"
#include "tests/support/text_file.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::vo {
namespace {

using testing::HasSubstr;

std::vector<uint8_t> CameraOf(double fx_px, int64_t seq) {
  RigCalibration rig;
  rig.left.width_px = rig.right.width_px = 640;
  rig.left.height_px = rig.right.height_px = 480;
  rig.left.fx_px = rig.right.fx_px = fx_px;
  rig.baseline_m = 0.1;
  camera_t message = bus::ToMessage(rig);
  message.header = {};
  message.header.seq = seq;
  return bus::Encoded(message);
}

SelfCalibration Learned() {
  SelfCalibration learned;
  learned.rows.emplace();
  learned.rows->offsets_px << 0.1, -1.0 / 3.0, 0.2, 0.0, 1e-7, 0.5;
  learned.rows->covariance_px2.diagonal().setConstant(0.01);
  learned.rows->covariance_px2(0, 1) = learned.rows->covariance_px2(1, 0) = 1.0 / 300.0;
  learned.disparities.emplace();
  learned.disparities->coefficients_px << -0.4, 0.1, 1.0 / 7.0;
  learned.disparities->covariance_px2.diagonal() << 1e-4, 2e-4, 3e-4;
  return learned;
}

class SelfCalibrationFile : public testing::Test {
 protected:
  std::string SentenceFor(const std::string& from, const std::string& to) {
    WriteSelfCalibration(path_, "0123", Learned());
    std::string text = ReadText(path_);
    text.replace(text.find(from), from.size(), to);
    std::ofstream(path_) << text;
    try {
      ReadSelfCalibration(path_, "0123");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing was thrown";
  }

  const bus::test::TemporaryFolder folder_;
  const std::string path_ = folder_ / "camera.self.yaml";
};

TEST_F(SelfCalibrationFile, RoundTripKeepsAllDigits) {
  WriteSelfCalibration(path_, "0123", Learned());
  const auto read = ReadSelfCalibration(path_, "0123");
  ASSERT_TRUE(read && read->rows && read->disparities);
  EXPECT_EQ(read->rows->offsets_px, Learned().rows->offsets_px);
  EXPECT_EQ(read->rows->covariance_px2, Learned().rows->covariance_px2);
  EXPECT_EQ(read->disparities->coefficients_px, Learned().disparities->coefficients_px);
  EXPECT_EQ(read->disparities->covariance_px2, Learned().disparities->covariance_px2);
}

TEST_F(SelfCalibrationFile, StoresOnlyAcceptedCalibrations) {
  SelfCalibration learned = Learned();
  learned.rows.reset();
  WriteSelfCalibration(path_, "0123", learned);
  const auto read = ReadSelfCalibration(path_, "0123");
  ASSERT_TRUE(read);
  EXPECT_FALSE(read->rows);
  EXPECT_TRUE(read->disparities);
}

TEST_F(SelfCalibrationFile, MissingOrOtherCalibrationIsIgnored) {
  EXPECT_FALSE(ReadSelfCalibration(path_, "0123"));
  WriteSelfCalibration(path_, "0123", Learned());
  EXPECT_FALSE(ReadSelfCalibration(path_, "0124"));
}

TEST_F(SelfCalibrationFile, InvalidFileIsNamed) {
  EXPECT_THAT(SentenceFor("0.01, ", ".nan, "), HasSubstr("camera.self.yaml: rows.covariance_px2 = nan"));
  EXPECT_THAT(SentenceFor("-0.4", "-0.4, 1"), HasSubstr("disparities.coefficients_px"));
  EXPECT_THAT(SentenceFor("-0.4", "4000"), HasSubstr("disparities.coefficients_px = 4e+19: must be within 1000"));
  EXPECT_THAT(SentenceFor("rows:", "rows: ["), HasSubstr("is not YAML"));
  EXPECT_THAT(SentenceFor("calibration: 0123", "camera: 0123"), HasSubstr("calibration is missing"));
}

TEST(NameOfCalibration, DependsOnTheCalibrationNotItsMessage) {
  EXPECT_EQ(NameOfCalibration(CameraOf(500.0, 1)), NameOfCalibration(CameraOf(500.0, 2)));
  EXPECT_NE(NameOfCalibration(CameraOf(500.0, 1)), NameOfCalibration(CameraOf(500.1, 1)));
  EXPECT_EQ(NameOfCalibration(CameraOf(500.0, 1)).size(), 16U);
}

}  // namespace
}  // namespace plslam::vo
