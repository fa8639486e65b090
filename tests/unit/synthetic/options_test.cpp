// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/synthetic/options.h"

#include <array>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/simulator.h"

namespace plslam::synthetic {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string ErrorOf(const std::string& description) {
  try {
    ParseOptions(description);
  } catch (const DatasetError& error) {
    return error.what();
  }
  return "no error";
}

TEST(SyntheticOptions, AllAreRead) {
  const Options o = ParseOptions(
      "street?seed=3&frames=30&loops=2&size=320x200&noise=1.5&blur=0.5&exposure=0&baseline=0.2&fov=90&rate=10&speed="
      "2&"
      "distorted=1&disparity_bias=0.25,0,-0.5&right_late_ms=-5&readout_ms=20&streaks=250&dirt=12&trajectory=a/b.txt&"
      "bodies=3&body=stop&share=0.3&standing=1&static_body=0.2");
  EXPECT_EQ(o.world, "street");
  EXPECT_EQ(o.seed, 3u);
  EXPECT_EQ(o.frames, 30);
  EXPECT_EQ(o.loops, 2);
  EXPECT_EQ(o.width_px, 320);
  EXPECT_EQ(o.height_px, 200);
  EXPECT_EQ(o.noise, 1.5);
  EXPECT_EQ(o.blur, 0.5);
  EXPECT_EQ(o.exposure, 0.0);
  EXPECT_EQ(o.baseline_m, 0.2);
  EXPECT_EQ(o.fov_deg, 90.0);
  EXPECT_EQ(o.rate_hz, 10.0);
  EXPECT_EQ(o.speed, 2.0);
  EXPECT_TRUE(o.distorted);
  EXPECT_EQ(o.right_late_ms, -5.0);
  EXPECT_EQ(o.readout_ms, 20.0);
  EXPECT_EQ(o.streaks, 250);
  EXPECT_EQ(o.dirt, 12);
  EXPECT_EQ(o.disparity_bias_px, (std::array<double, 3>{0.25, 0.0, -0.5}));
  EXPECT_EQ(o.trajectory, "a/b.txt");
  EXPECT_EQ(o.bodies, 3);
  EXPECT_EQ(o.body, BodyMotion::kStop);
  EXPECT_EQ(o.share, 0.3);
  EXPECT_TRUE(o.standing);
  EXPECT_EQ(o.static_body, 0.2);
  const Options sensed = ParseOptions("room?imu=250&imu_class=bmi055");
  EXPECT_EQ(sensed.imu_rate_hz, 250.0);
  EXPECT_EQ(sensed.imu_class, "bmi055");
  EXPECT_EQ(ParseOptions("room?changed_after=3").changed_after, 3);
}

TEST(SyntheticOptions, UnknownWorldNamesTheNearest) {
  EXPECT_THAT(ErrorOf("rom"), AllOf(HasSubstr("'rom'"), HasSubstr("nearest is 'room'"), HasSubstr("whitewall")));
  EXPECT_THAT(ErrorOf(""), HasSubstr("unknown world"));
}

TEST(SyntheticOptions, UnknownOptionNamesTheNearest) {
  EXPECT_THAT(ErrorOf("room?sed=3"), AllOf(HasSubstr("'sed'"), HasSubstr("nearest is 'seed'")));
  EXPECT_THAT(ErrorOf("room?&"), HasSubstr("unknown option"));
}

TEST(SyntheticOptions, BadValuesNameTheirBounds) {
  for (const char* bad :
       {"frames=0",   "frames=1.5",  "frames=x",  "noise=-1",    "noise=nan",     "fov=180",      "seed=-1",
        "blur=2",     "rate=0",      "speed=1e9", "distorted=2", "loops=1000000", "baseline=inf", "bodies=-1",
        "bodies=1.5", "bodies=1000", "share=0",   "share=1.5",   "standing=2",    "static_body=1"}) {
    EXPECT_THAT(ErrorOf(std::string("room?") + bad), AllOf(HasSubstr(bad[0] == 'f' ? "f" : ""), HasSubstr(" from ")))
        << bad;
  }
  for (const char* bad : {"size=752", "size=752x", "size=x480", "size=1x1", "size=99999x480", "size=752x480x3"}) {
    EXPECT_THAT(ErrorOf(std::string("room?") + bad), HasSubstr("WIDTHxHEIGHT")) << bad;
  }
  for (const char* bad : {"0", "0,0", "0,0,", "0,0,0,0", "0;0;0", "0,0,6", "0,x,0", "nan,0,0"}) {
    EXPECT_THAT(ErrorOf(std::string("room?disparity_bias=") + bad), HasSubstr("three numbers of pixels from -5 to 5"))
        << bad;
  }
  EXPECT_THAT(ErrorOf("street?changed_after=1"), HasSubstr("is of the world room"));
  EXPECT_THAT(ErrorOf("room?changed_after=1&bodies=1"), HasSubstr("changed_after excludes bodies"));
  EXPECT_THAT(ErrorOf("room?seed="), HasSubstr("has no value"));
  EXPECT_THAT(ErrorOf("room?seed"), HasSubstr("has no value"));
}

TEST(SyntheticOptions, BodiesNeedNoMoreThanTheirMotion) {
  EXPECT_EQ(ParseOptions("street").bodies, 0);
  EXPECT_EQ(ParseOptions("street?body=overtake").bodies, 1);
  EXPECT_GT(ParseOptions("street?body=crowd").bodies, 10);
  EXPECT_EQ(ParseOptions("street?body=crowd&bodies=0").bodies, 0);
  EXPECT_EQ(ParseOptions("street?bodies=2").body, BodyMotion::kLead);
  EXPECT_EQ(ParseOptions("street?bodies=2&standing=1").body, BodyMotion::kCross);
}

TEST(SyntheticOptions, BodiesThatMakeNoSenseAreRefused) {
  EXPECT_THAT(ErrorOf("street?body=leed"),
              AllOf(HasSubstr("'leed'"), HasSubstr("nearest is 'lead'"), HasSubstr("crowd")));
  EXPECT_THAT(ErrorOf("street?share=0.5"), AllOf(HasSubstr("share="), HasSubstr("add bodies=1")));
  EXPECT_THAT(ErrorOf("street?standing=1&body=lead"), AllOf(HasSubstr("standing=1"), HasSubstr("body=cross")));
}

TEST(SyntheticOptions, FaultsOfTheSensorHaveTheirOwnSizes) {
  EXPECT_EQ(ParseOptions("room?imu=200").imu_fault, "");
  EXPECT_EQ(ParseOptions("room?imu=200&imu_fault=offset").imu_fault_size, 20.0);
  EXPECT_EQ(ParseOptions("room?imu_fault_size=-100&imu=200&imu_fault=offset").imu_fault_size, -100.0);
  EXPECT_THAT(ErrorOf("room?imu_fault=gaps"), HasSubstr("add imu=200"));
  EXPECT_THAT(ErrorOf("room?imu=200&imu_fault_size=1"), HasSubstr("add imu_fault=offset"));
  EXPECT_THAT(ErrorOf("room?imu=200&imu_fault=gap"), HasSubstr("the nearest is 'gaps'"));
  EXPECT_THAT(ErrorOf("room?imu=200&imu_fault=gaps&imu_fault_size=3"), HasSubstr("must be from 0 to 2"));
}

TEST(SyntheticOptions, OpeningReportsTheSameError) { EXPECT_THROW(OpenSyntheticDataset("nowhere"), DatasetError); }

}  // namespace
}  // namespace plslam::synthetic
