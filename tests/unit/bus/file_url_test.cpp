// SPDX-License-Identifier: BSD-3-Clause
#include <ctime>

#include <gtest/gtest.h>

#include "core/bus/logs/log_reader.h"
#include "core/bus/logs/log_writer.h"
#include "core/bus/transport/transport.h"
#include "plslam/pose_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using test::Eventually;
using test::RunningBus;
using test::TemporaryFolder;
using test::Waiter;

void WritePoses(const std::string& log, int n) {
  BusOptions options;
  options.url = "file://" + log + "?mode=w";
  Bus writer(options, "writer");
  for (int i = 0; i < n; ++i) {
    pose_t pose{};
    pose.frame_id = i;
    writer.Publish(kPose, pose);
  }
}

TEST(FileUrl, ReceiveAfterTheEndWaitsForWake) {
  const TemporaryFolder folder;
  const std::string log = folder / "log";
  WritePoses(log, 5);
  Transport transport("file://" + log + "?mode=r&speed=0");
  int received = 0;
  transport.SetReceiver([&](std::string_view, ByteView) { ++received; });
  transport.Listen("POSE");
  while (transport.Receive(1000)) {
  }
  EXPECT_EQ(received, 5);
  constexpr std::chrono::milliseconds kPause{50};
  const auto duration_of_receive = [&](std::chrono::milliseconds limit) {
    const auto began = std::chrono::steady_clock::now();
    EXPECT_FALSE(transport.Receive(static_cast<int>(limit.count())));
    return std::chrono::steady_clock::now() - began;
  };
  EXPECT_GE(duration_of_receive(kPause), kPause) << "who asks again and again keeps a core busy";
  transport.Wake();
  EXPECT_LT(duration_of_receive(std::chrono::seconds(60)), std::chrono::seconds(30));
}

TEST(FileUrl, RecordedLogFeedsAReader) {
  const TemporaryFolder folder;
  const std::string log = folder / "log";
  WritePoses(log, 50);
  BusOptions options;
  options.url = "file://" + log + "?mode=r&speed=0";
  Waiter received;
  RunningBus reader(options, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, received.value());
    received.Add();
  });
  reader.Start();
  EXPECT_TRUE(received.Reaches(50)) << received.value();
  // The process must then be idle: there is no partner to greet or acknowledge.
  EXPECT_TRUE(Eventually([] {
    const std::clock_t before = std::clock();
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return std::clock() - before < CLOCKS_PER_SEC / 100;
  })) << "the process uses more than 5 % of a core";
}

// As lcm-logger makes them where datagrams are dropped.
TEST(FileUrl, MissingMessagesDoNotEndTheLog) {
  const TemporaryFolder folder;
  WritePoses(folder / "whole", 20);
  {
    LogReader whole(folder / "whole");
    LogWriter holes(folder / "holes");
    for (int i = 0; const auto event = whole.Next(); ++i) {
      const auto data = whole.Data(event->data_offset, event->data_bytes);
      if (i != 5 && i != 6 && i != 12) holes.Write(event->channel, *data, event->timestamp_us);
    }
  }
  BusOptions options;
  options.url = "file://" + (folder / "holes") + "?mode=r&speed=0";
  Waiter received;
  RunningBus reader(options, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  EXPECT_TRUE(received.Reaches(17)) << received.value();
}

}  // namespace
}  // namespace plslam::bus
