#include "core/bus/bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/tracks_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using test::PrivateUrl;
using test::RunningBus;
using test::Waiter;

BusOptions OptionsFor(const std::string& url) {
  BusOptions options;
  options.url = url;
  return options;
}

pose_t PoseOf(int64_t frame_id) {
  pose_t pose{};
  pose.frame_id = frame_id;
  pose.header.t_ns = 1000 * frame_id;
  return pose;
}

class BusOver : public testing::TestWithParam<const char*> {
 protected:
  static std::string Url() { return std::string(GetParam()) == "udpm" ? PrivateUrl() : "memq://"; }
};

TEST_P(BusOver, OwnMessagesArriveInOrder) {
  RunningBus bus(OptionsFor(Url()));
  std::vector<int64_t> frames;
  Waiter received;
  bus->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    frames.push_back(pose.frame_id);
    received.Add();
  });
  bus.Start();
  for (int i = 0; i < 100; ++i) bus->Publish(kPose, PoseOf(i));
  ASSERT_TRUE(received.Reaches(100));
  bus.Join();
  for (int i = 0; i < 100; ++i) EXPECT_EQ(frames[i], i);
  EXPECT_EQ(bus->counters().sent, 100);
  EXPECT_EQ(bus->counters().rejected, 0);
}

INSTANTIATE_TEST_SUITE_P(Url, BusOver, testing::Values("udpm", "memq"));

TEST(Bus, TwoProcessesExchangeOrderedMessages) {
  const std::string url = PrivateUrl();
  RunningBus reader(OptionsFor(url));
  Waiter received;
  int64_t next = 0;
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, next++);
    EXPECT_EQ(pose.header.t_ns, 1000 * pose.frame_id);
    received.Add();
  });
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  for (int i = 0; i < 2000; ++i) publisher.Publish(kPose, PoseOf(i));
  ASSERT_TRUE(received.Reaches(2000)) << received.value();
}

}  // namespace
}  // namespace plslam::bus
