// SPDX-License-Identifier: BSD-3-Clause
#include "adapter/node/motion_source.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

#include "core/bus/run_loop.h"
#include "plslam/warning_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::adapter {
namespace {

TEST(MotionSource, MissingOdometryIsReportedOnce) {
  bus::BusOptions options;
  options.url = bus::test::PrivateUrl();
  bus::test::RunningBus listener(options, "listener");
  std::atomic<int> n_warnings = 0;
  listener->Subscribe<warning_t>(bus::kWarning, [&](const warning_t& message) {
    EXPECT_EQ(message.code, "robot_odometry_missing");
    EXPECT_NE(message.sentence.find("no message arrives on /wheels (adapter.robot_odometry)"), std::string::npos);
    ++n_warnings;
  });
  listener.Start();
  bus::Process process("adapter", options);
  std::thread runs([&] { process.bus().Run(); });
  {
    bus::StockLcm foreign(bus::test::PrivateUrl(), "foreign");
    std::atomic<int64_t> n_frames = 0;
    const MotionSource source(process, foreign, "/wheels", [&] { return ++n_frames < 3 ? 0 : 1000; });
    EXPECT_TRUE(bus::test::Eventually([&] { return n_warnings > 0; }));
    EXPECT_TRUE(bus::test::Eventually([&] { return n_frames >= 5; })) << "it would be reported again";
  }
  process.bus().Stop();
  runs.join();
  listener.Join();
  EXPECT_EQ(n_warnings, 1);
}

}  // namespace
}  // namespace plslam::adapter
