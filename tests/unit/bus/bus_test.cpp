// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/process/process_usage.h"
#include "plslam/command_t.hpp"
#include "plslam/map_update_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "plslam/tracks_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using test::Eventually;
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
  std::vector<int64_t> frames;
  Waiter received;
  RunningBus bus(OptionsFor(Url()));
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
  Waiter received;
  int64_t next = 0;
  RunningBus reader(OptionsFor(url));
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

/// Everything published arrives in order although the reader throws datagrams away.
class LossyBus : public testing::TestWithParam<double> {};

TEST_P(LossyBus, OrderedMessagesArriveDespiteLosses) {
  const std::string url = PrivateUrl();
  BusOptions options = OptionsFor(url);
  options.drop_fraction = GetParam();
  Waiter received;
  std::vector<int64_t> frames;
  RunningBus reader(options, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    frames.push_back(pose.frame_id);
    received.Add();
  });
  reader.Start();
  RunningBus publisher(options, "publisher");
  static constexpr int kMessages = 3000;
  for (int i = 0; i < kMessages; ++i) publisher->Publish(kPose, PoseOf(i));
  ASSERT_TRUE(received.Reaches(kMessages)) << received.value();
  EXPECT_TRUE(publisher->Flush(std::chrono::seconds(10)));
  reader.Join();
  ASSERT_EQ(frames.size(), static_cast<size_t>(kMessages));
  for (int i = 0; i < kMessages; ++i) ASSERT_EQ(frames[static_cast<size_t>(i)], i);
  EXPECT_EQ(reader->counters().lost, reader->counters().repaired);
  EXPECT_GT(publisher->counters().resent, 0);
}

INSTANTIATE_TEST_SUITE_P(Drop, LossyBus, testing::Values(0.05, 0.2));

TEST(Bus, LateJoinerGetsEverythingFromTheFirstMessageOn) {
  const std::string url = PrivateUrl();
  BusOptions options = OptionsFor(url);
  options.history_bytes = 200'000;  // so that most of it is read from disk
  Bus publisher(options, "publisher");
  static constexpr int kMessages = 2000;
  for (int i = 0; i < kMessages; ++i) publisher.Publish(kPose, PoseOf(i));
  Waiter received;
  int64_t next = 0;
  RunningBus reader(OptionsFor(url), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, next++);
    received.Add();
  });
  reader.Start();
  ASSERT_TRUE(received.Reaches(kMessages)) << received.value();
  // An announcement made while the publisher was at work can be heard only after the reader has joined (a busy
  // machine). The messages after it then count as lost, and as repaired.
  EXPECT_EQ(reader->counters().lost, reader->counters().repaired);
}

TEST(Bus, LateReaderGetsAcknowledgedMessages) {
  const std::string url = PrivateUrl();
  static_assert(kCommand.retention == Retention::kUnacknowledged);
  Waiter first, second;
  RunningBus prompt(OptionsFor(url), "prompt");
  prompt->Subscribe<command_t>(kCommand, [&](const command_t&) { first.Add(); });
  prompt.Start();
  Bus publisher(OptionsFor(url), "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kCommand, 1));
  for (int i = 0; i < 10; ++i) publisher.Publish(kCommand, command_t{});
  ASSERT_TRUE(first.Reaches(10));
  ASSERT_TRUE(publisher.Flush(std::chrono::seconds(10))) << "all known readers have acknowledged all";
  RunningBus late(OptionsFor(url), "late");
  late->Subscribe<command_t>(kCommand, [&](const command_t&) { second.Add(); });
  late.Start();
  EXPECT_TRUE(second.Reaches(10)) << second.value();
}

TEST(Bus, ReaderGivesUpGapsOfAnExitedPublisher) {
  const std::string url = PrivateUrl();
  BusOptions deaf = OptionsFor(url);
  deaf.drop_fraction = 0.5;
  deaf.drop_seed = 3;
  deaf.give_up_s = 1.0;
  Waiter received;
  int64_t newest = -1;
  RunningBus reader(deaf, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_GT(pose.frame_id, newest);
    newest = pose.frame_id;
    received.Add();
  });
  reader.Start();
  {
    // Ignores requests permanently: like an exited publisher that has sent something.
    BusOptions dead = OptionsFor(url);
    dead.drop_fraction = 0.9999;
    dead.max_wait_ms = 0;
    Bus publisher(dead, "publisher");
    for (int i = 0; i < 40; ++i) publisher.Publish(kPose, PoseOf(i));
  }
  // Gaps are given up one after another, each after the publisher has been silent for long enough.
  ASSERT_TRUE(received.Reaches(5, std::chrono::seconds(60)));
  ASSERT_TRUE(Eventually([&] {
    const BusCounters c = reader->counters();
    return c.lost > c.repaired && received.value() + c.lost - c.repaired >= 20;
  }));
}

TEST(Bus, SlowHandlerThrottlesThePublisher) {
  const std::string url = PrivateUrl();
  BusOptions options = OptionsFor(url);
  options.queue_bytes = 200'000;
  Waiter received;
  std::mutex gate;
  int64_t next = 0;
  RunningBus reader(options, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    const std::lock_guard lock(gate);
    EXPECT_EQ(pose.frame_id, next++);
    received.Add();
  });
  options.max_wait_ms = 50;
  options.history_bytes = 200'000;
  static constexpr int kMessages = 3000;
  Bus publisher(options, "publisher");
  {
    const std::lock_guard closed(gate);
    reader.Start();
    ASSERT_TRUE(test::WaitForReaders(publisher, kPose, 1));
    for (int i = 0; i < kMessages; ++i) publisher.Publish(kPose, PoseOf(i));
    EXPECT_LT(received.value(), kMessages);
  }
  ASSERT_TRUE(received.Reaches(kMessages)) << received.value();
  EXPECT_EQ(reader->counters().lost, reader->counters().repaired);
}

TEST(Bus, LatestMessageOvertakesOlderOnes) {
  std::vector<int64_t> frames;
  Waiter received;
  Waiter entered;
  std::mutex gate;
  RunningBus bus(OptionsFor("memq://"));
  bus->Subscribe<tracks_t>(kTracksLive, [&](const tracks_t& tracks) {
    entered.Add();
    const std::lock_guard lock(gate);
    frames.push_back(tracks.frame_id);
    received.Add();
  });
  bus.Start();
  const auto publish = [&](int64_t id) {
    tracks_t tracks{};
    tracks.frame_id = id;
    bus->Publish(kTracksLive, tracks);
  };
  {
    const std::lock_guard closed(gate);
    publish(0);
    ASSERT_TRUE(entered.Reaches(1));
    for (int i = 1; i <= 10; ++i) publish(i);
    ASSERT_TRUE(Eventually([&] { return bus->counters().skipped == 9; })) << bus->counters().skipped;
  }
  ASSERT_TRUE(received.Reaches(2));
  bus.Join();
  EXPECT_EQ(frames, (std::vector<int64_t>{0, 10}));
}

TEST(Bus, BestEffortReaderNeitherRequestsNorThrottles) {
  const std::string url = PrivateUrl();
  Waiter received;
  RunningBus reader(OptionsFor(url), "reader");
  reader->SubscribeBestEffort<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  for (int i = 0; i < 10; ++i) publisher.Publish(kPose, PoseOf(i));
  ASSERT_TRUE(received.Reaches(10));
  EXPECT_EQ(publisher.ReaderCount(kPose), 0);
}

TEST(Bus, AnEmptyArrayArrivesEmptyAfterAFullOne) {
  const std::string url = PrivateUrl();
  std::vector<size_t> sizes;
  Waiter received;
  RunningBus reader(OptionsFor(url));
  reader->Subscribe<map_update_t>(kMapUpdate, [&](const map_update_t& update) {
    sizes.push_back(update.removed_points.size());
    received.Add();
  });
  reader.Start();
  Bus publisher(OptionsFor(url), "publisher");
  map_update_t update{};
  for (const int32_t n : {3, 0}) {
    update.n_removed_points = n;
    update.removed_points.assign(static_cast<size_t>(n), 7);
    publisher.Publish(kMapUpdate, update);
  }
  ASSERT_TRUE(received.Reaches(2)) << received.value();
  reader.Join();
  EXPECT_THAT(sizes, testing::ElementsAre(3, 0));
}

TEST(Bus, PrefixesSeparateRobots) {
  const std::string url = PrivateUrl();
  BusOptions one = OptionsFor(url);
  one.prefix = "robot.1/";
  BusOptions two = OptionsFor(url);
  two.prefix = "robotx1/";
  Waiter received;
  RunningBus reader(one, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, 1);
    received.Add();
  });
  reader.Start();
  Bus other(two, "other");
  Bus same(one, "same");
  other.Publish(kPose, PoseOf(2));
  same.Publish(kPose, PoseOf(1));
  ASSERT_TRUE(received.Reaches(1));
  EXPECT_EQ(reader->counters().rejected, 0);
}

TEST(Bus, TimersAndPostedCallsRunOnTheThreadOfRun) {
  Waiter ticks;
  Waiter posted;
  std::thread::id thread;
  RunningBus bus(OptionsFor("memq://"));
  bus->Every(std::chrono::milliseconds(2), [&] {
    thread = std::this_thread::get_id();
    ticks.Add();
  });
  bus.Start();
  bus->Post([&] {
    EXPECT_TRUE(ticks.value() == 0 || thread == std::this_thread::get_id());
    posted.Add();
  });
  EXPECT_TRUE(ticks.Reaches(5));
  EXPECT_TRUE(posted.Reaches(1));
  bus.Join();
  EXPECT_NE(thread, std::this_thread::get_id());
}

TEST(Bus, StopsBeforeRun) {
  Bus bus(OptionsFor("memq://"), "test");
  bus.Stop();
  bus.Run();
}

TEST(Bus, InvalidOptionsAreRefused) {
  const auto error_of = [](const BusOptions& options) -> std::string {
    try {
      const Bus bus(options, "test");
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  using testing::HasSubstr;
  EXPECT_THAT(error_of(OptionsFor("ftp://x")), HasSubstr("bus.url: ftp://x is not an LCM URL"));
  EXPECT_THAT(error_of(OptionsFor("tcpq://127.0.0.1:1")), HasSubstr("no relay answers"));
  EXPECT_THAT(error_of(OptionsFor("tcpq://no-such-host.invalid:7700")),
              HasSubstr("the host no-such-host.invalid is not known"));
  EXPECT_THAT(error_of(OptionsFor("udpm://239.255.76.67:7667?tll=1")),
              HasSubstr("has the unknown parameter 'tll' (known: ttl, recv_buf_size)"));
  EXPECT_THAT(error_of(OptionsFor("tcpq://127.0.0.1:1?ttl=1")),
              HasSubstr("unknown parameter 'ttl' (there are none)"));
  BusOptions options = OptionsFor("memq://");
  options.key_file = "/nowhere/key";
  EXPECT_THAT(error_of(options), HasSubstr("/nowhere/key cannot be read"));
  options = OptionsFor("memq://");
  options.history_dir = "/proc/nowhere";
  EXPECT_THAT(error_of(options), HasSubstr("bus.history_dir: /proc/nowhere"));
  options = OptionsFor("memq://");
  options.prefix = "a*";
  EXPECT_THAT(error_of(options), HasSubstr("bus.prefix"));
}

TEST(Bus, RefusesOversizedMessagesAndOtherTypes) {
  Bus bus(OptionsFor("memq://"), "test");
  status_t status{};
  status.configuration.assign(70'000, 'x');
  EXPECT_THROW(bus.Publish(kStatus, status), std::length_error);
  EXPECT_THROW(bus.Publish(kPose, status_t{}), std::logic_error);
  EXPECT_THROW(bus.Subscribe<status_t>(kPose, [](const status_t&) {}), std::logic_error);
}

TEST(Bus, MemoryStaysBoundedOverManyMessages) {
#ifdef PLSLAM_SANITIZED
  GTEST_SKIP() << "sanitizers keep memory of their own";
#endif
  const std::string url = PrivateUrl();
  const test::TemporaryFolder folder;
  BusOptions options = OptionsFor(url);
  options.history_bytes = 1'000'000;
  options.history_dir = folder.path();
  Waiter received;
  RunningBus reader(OptionsFor(url), "reader");
  reader->Subscribe<command_t>(kCommand, [&](const command_t&) {});
  reader->Subscribe<stream_t>(kStream, [&](const stream_t&) { received.Add(); });
  reader.Start();
  Bus publisher(options, "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kStream, 1));
  static constexpr int kMessages = 200'000;
  double early = 0.0;
  for (int i = 0; i < kMessages; ++i) {
    publisher.Publish(kStream, stream_t{});
    if (i == kMessages / 10) early = CurrentUsage().memory_mb;
  }
  ASSERT_TRUE(received.Reaches(kMessages, std::chrono::seconds(60)));
  std::printf("  %.1f MB after %d messages, %.1f MB after %d\n", early, kMessages / 10, CurrentUsage().memory_mb,
              kMessages);
  EXPECT_LT(CurrentUsage().memory_mb, early + 10.0);
  EXPECT_EQ(reader->counters().lost, reader->counters().repaired);
}

}  // namespace
}  // namespace plslam::bus
