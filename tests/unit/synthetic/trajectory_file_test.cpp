// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/simulator.h"

namespace plslam::synthetic {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class TrajectoryFile : public testing::Test {
 protected:
  std::string Write(const std::string& text) {
    path_ =
        testing::TempDir() + "synthetic_" + testing::UnitTest::GetInstance()->current_test_info()->name() + ".txt";
    std::ofstream(path_) << text;
    return path_;
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string ErrorOf(const std::string& text) {
    try {
      ReadPoses(Write(text));
    } catch (const DatasetError& error) {
      return error.what();
    }
    return "no error";
  }

  std::string path_;
};

// Level cameras (x right, y down, z forward), z upwards in the world, walking along x.
constexpr const char* kTum =
    "# time x y z qx qy qz qw\n"
    "1.5 0 0 1 0.5 -0.5 0.5 -0.5\n"
    "1.6 0.1 0 1 0.5 -0.5 0.5 -0.5\n"
    "1.75 3 0.2 1.1 -0.5 0.5 -0.5 0.5\n";

constexpr const char* kKitti =
    "1 0 0 0 0 1 0 0 0 0 1 0\n"
    "1 0 0 0 0 1 0 -0.1 0 0 1 20\n"
    "1 0 0 1 0 1 0 0 0 0 1 60\n";

TEST_F(TrajectoryFile, TumPathIsUsedUnchanged) {
  for (const std::string world : {"room", "corridor", "street", "whitewall"}) {
    const Simulator simulator(ParseOptions(world + "?size=160x120&trajectory=" + Write(kTum)));
    ASSERT_EQ(simulator.size(), 3);
    EXPECT_EQ(simulator.t_ns(0), 1500000000);
    EXPECT_EQ(simulator.t_ns(2), 1750000000);
    EXPECT_EQ(simulator.T_w_c(2).translation(), Eigen::Vector3d(3.0, 0.2, 1.1));
    EXPECT_NEAR(simulator.T_w_c(1).R()(0, 2), 1.0, 1e-12);
    EXPECT_NEAR(simulator.world().up().z(), 1.0, 1e-12) << world;
    for (int i = 0; i < 3; ++i) {
      for (const float depth : simulator.RenderDepth(i)) {
        ASSERT_TRUE(depth == 0.0F || depth > 0.4F) << world << " frame " << i << " depth " << depth;
      }
    }
    EXPECT_FALSE(simulator.Render(1).left.empty());
  }
}

TEST_F(TrajectoryFile, KittiHasItsOwnVertical) {
  const Simulator simulator(ParseOptions("street?size=160x120&rate=10&trajectory=" + Write(kKitti)));
  ASSERT_EQ(simulator.size(), 3);
  EXPECT_EQ(simulator.t_ns(1), 100000000);
  EXPECT_NEAR(simulator.world().up().y(), -1.0, 1e-12);
  EXPECT_EQ(simulator.T_w_c(1).translation(), Eigen::Vector3d(0.0, -0.1, 20.0));
  // The ground is in view below the horizon, and there are houses beside the way.
  const std::vector<float> depth = simulator.RenderDepth(0);
  EXPECT_GT(depth[115 * 160 + 80], 1.0F);
  EXPECT_GT(depth[60 * 160 + 10], 3.0F);
  EXPECT_LT(depth[60 * 160 + 10], 60.0F);
}

TEST_F(TrajectoryFile, FramesCutTheFile) {
  EXPECT_EQ(Simulator(ParseOptions("room?size=64x48&frames=2&trajectory=" + Write(kTum))).size(), 2);
  EXPECT_THROW(Simulator(ParseOptions("room?size=64x48&frames=4&trajectory=" + Write(kTum))), DatasetError);
}

TEST_F(TrajectoryFile, OnePoseIsEnough) {
  const Simulator simulator(
      ParseOptions("room?size=64x48&blur=1&trajectory=" + Write("0 0 0 1 0.5 -0.5 0.5 -0.5\n")));
  EXPECT_EQ(simulator.size(), 1);
  EXPECT_EQ(simulator.Render(0).left.cols, 64);
}

TEST_F(TrajectoryFile, ErrorsNameFileAndLine) {
  EXPECT_THAT(ErrorOf("# nothing\n"), HasSubstr("no pose"));
  EXPECT_THAT(ErrorOf("1 2 3\n"), AllOf(HasSubstr(".txt:1:"), HasSubstr("3 numbers")));
  EXPECT_THAT(ErrorOf(std::string(kTum) + "1.8 0 0 0 0 0 0 nan\n"), AllOf(HasSubstr(":5:"), HasSubstr("nan")));
  EXPECT_THAT(ErrorOf(std::string(kTum) + "1.8 0 0 0 x 0 0 1\n"), AllOf(HasSubstr(":5:"), HasSubstr("'x' is not")));
  EXPECT_THAT(ErrorOf(std::string(kTum) + "1.8 0 0 0 0 0 0 2\n"), AllOf(HasSubstr(":5:"), HasSubstr("quaternion")));
  EXPECT_THAT(ErrorOf(std::string(kTum) + "1.7 0 0 0 0 0 0 1\n"), AllOf(HasSubstr(":5:"), HasSubstr("not increase")));
  EXPECT_THAT(ErrorOf("2 0 0 0 0 1 0 0 0 0 1 0\n"), AllOf(HasSubstr(":1:"), HasSubstr("rotation")));
  EXPECT_THAT(ErrorOf("0 1e9 0 0 0 0 0 1\n"), HasSubstr("100 km"));
  EXPECT_THAT(ErrorOf("1e300 0 0 0 0 0 0 1\n"), HasSubstr("nanoseconds"));
  EXPECT_THROW(ReadPoses("no/such/file"), DatasetError);
}

}  // namespace
}  // namespace plslam::synthetic
