// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "core/datasets/open_dataset.h"
#include "loop_process/loop_service.h"
#include "tests/support/data_folder.h"
#include "tests/support/loop_run.h"

namespace plslam::test {
namespace {

// A flight through one room with up to 7 s between frames, which passes most places several times.
TEST(Revisits, RevisitsOfARealRoomAreClosed) {
  PLSLAM_REQUIRE_DATA(folder, "euroc_V1_01_sparse");
  const auto dataset = OpenDataset(folder.string(), "");
  const LoopRun run = RunLoops(*dataset, loop::LoadPlaces({}, {}), {});
  EXPECT_GE(run.revisits.keyframes, 15);
  EXPECT_GE(run.revisits.closed_keyframes, run.revisits.keyframes - 2);
  for (const LoopOfRun& loop : run.loops) EXPECT_FALSE(loop.IsFalse()) << "frame " << loop.frame;
  EXPECT_LT(AbsoluteTrajectoryError(run.slam.final), 0.13);
}

}  // namespace
}  // namespace plslam::test
