// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/unused_inputs.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "core/bus/run_loop.h"
#include "plslam/mask_t.hpp"
#include "plslam/robot_motion_t.hpp"
#include "plslam/warning_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::vo {
namespace {

TEST(UnusedInputs, AreReportedOnceEach) {
  bus::BusOptions options;
  options.url = bus::test::PrivateUrl();
  bus::test::RunningBus robot(options, "robot");
  std::atomic<int> n_masks = 0, n_motions = 0;
  robot->Subscribe<warning_t>(bus::kWarning, [&](const warning_t& message) {
    if (message.code == "masks_unused") ++n_masks;
    if (message.code == "robot_motion_unused") ++n_motions;
  });
  robot.Start();
  bus::Process process("vo", options);
  WarnOfUnusedInputs(process, VoOptions{});
  std::thread runs([&] { process.bus().Run(); });
  const auto publish = [&] {
    robot->Publish(bus::kMask, mask_t{});
    robot->Publish(bus::kRobotMotion, robot_motion_t{});
  };
  EXPECT_TRUE(bus::test::Eventually([&] {
    publish();
    return n_masks > 0 && n_motions > 0;
  }));
  for (int i = 0; i < 20; ++i) publish();
  process.bus().StopWhenHandled();
  runs.join();
  robot.Join();
  EXPECT_EQ(n_masks, 1);
  EXPECT_EQ(n_motions, 1);
}

}  // namespace
}  // namespace plslam::vo
