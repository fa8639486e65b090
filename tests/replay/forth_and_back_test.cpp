// SPDX-License-Identifier: BSD-3-Clause
#include <string>

#include <gtest/gtest.h>

#include "core/datasets/open_dataset.h"
#include "loop_process/loop_service.h"
#include "tests/support/data_folder.h"
#include "tests/support/loop_run.h"
#include "tests/support/worse_images.h"

namespace plslam::test {
namespace {

double PathLength(const std::vector<OdometryFrame>& frames) {
  double length_m = 0.0;
  for (size_t i = 1; i < frames.size(); ++i) {
    length_m += (frames[i].T_odom_l.translation() - frames[i - 1].T_odom_l.translation()).norm();
  }
  return length_m;
}

struct Journey {
  std::string folder;
  double noise_sigma;
  double ate_m;
};

class ForthAndBack : public testing::TestWithParam<Journey> {};

// Without noise the way back consists of images that are the same bit by bit.
TEST_P(ForthAndBack, EndsWhereItBegan) {
  PLSLAM_REQUIRE_DATA(folder, GetParam().folder);
  const auto dataset = OpenDataset(folder.string(), "");
  LoopRunOptions options;
  options.forth_and_back = true;
  const LoopRun run =
      RunLoops(WorseImages(*dataset, {.noise_sigma = GetParam().noise_sigma}), loop::LoadPlaces({}, {}), options);
  const auto& frames = run.slam.final;
  ASSERT_GT(frames.size(), 100u);
  const double gap_m = (frames.back().T_odom_l.translation() - frames.front().T_odom_l.translation()).norm();
  EXPECT_LT(gap_m, 0.01 * PathLength(frames));
  EXPECT_LT(AbsoluteTrajectoryError(frames), GetParam().ate_m);
  EXPECT_EQ(LostFrames(run.slam.live), 0);
  for (const LoopOfRun& loop : run.loops) EXPECT_FALSE(loop.IsFalse()) << "frame " << loop.frame;
  EXPECT_EQ(run.revisits.closed, run.revisits.total);
}

INSTANTIATE_TEST_SUITE_P(Sequences, ForthAndBack,
                         testing::Values(Journey{"kitti_03", 0.0, 0.075}, Journey{"kitti_03", 6.0, 0.11},
                                         Journey{"euroc_MH_01_a", 0.0, 0.0048}, Journey{"euroc_MH_01_a", 6.0, 0.006}),
                         [](const auto& test) {
                           return test.param.folder + (test.param.noise_sigma > 0.0 ? "_noisy" : "");
                         });

}  // namespace
}  // namespace plslam::test
