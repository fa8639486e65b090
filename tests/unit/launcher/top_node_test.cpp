// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plslam/node/top_node.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/bus/run_loop.h"
#include "core/bus/transport/transport.h"
#include "plslam/pose_t.hpp"
#include "plslam/status_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::launcher {
namespace {

using bus::test::Eventually;
using testing::HasSubstr;

/// A passive listener on the bus, and robots that publish.
class TopNodeTest : public testing::Test {
 protected:
  static bus::BusOptions On(const std::string& url, const std::string& prefix) {
    bus::BusOptions options;
    options.url = url;
    options.prefix = prefix;
    return options;
  }

  static status_t StatusOf(const std::string& process, double uptime_s, double cpu_s, double frames) {
    status_t status{};
    status.process = process;
    status.host = "here";
    status.pid = 7;
    status.state = "running";
    status.uptime_s = uptime_s;
    status.cpu_s = cpu_s;
    status.memory_mb = 12.0;
    for (const auto& [name, value] : {std::pair("frames", frames), std::pair("queue.frames", 3.0)}) {
      counter_t counter;
      counter.name = name;
      counter.value = value;
      status.counters.push_back(counter);
    }
    status.n_counters = static_cast<int32_t>(status.counters.size());
    return status;
  }

  /// Takes until there are so many processes, or the time is over.
  BusLoad TakeWith(size_t n_processes, double rate_hz = -1.0) {
    BusLoad load;
    Eventually([&] {
      load = node_.Take(bus::NowS());
      return load.processes.size() >= n_processes && load.processes.front().rate_hz >= rate_hz;
    });
    return load;
  }

  const std::string url_ = bus::test::PrivateUrl();
  bus::Bus bus_{On(url_, ""), "top"};
  TopNode node_{bus_};
  bus::Bus ann_{On(url_, "ann/"), "vo"};
  bus::Bus bob_{On(url_, "bob/"), "vo"};
};

TEST_F(TopNodeTest, ListsProcessesPerRobot) {
  ann_.Publish(bus::kStatus, StatusOf("vo", 1.0, 0.5, 10));
  bob_.Publish(bus::kStatus, StatusOf("vo", 1.0, 0.5, 10));
  const BusLoad load = TakeWith(2);
  ASSERT_EQ(load.processes.size(), 2U);
  EXPECT_EQ(load.processes[0].robot, "ann/");
  EXPECT_EQ(load.processes[1].robot, "bob/");
  EXPECT_EQ(load.processes[0].queue, 3);
  EXPECT_LT(load.processes[0].rate_hz, 0.0);  // a single status gives no rate
}

TEST_F(TopNodeTest, RatesAreBetweenStatuses) {
  ann_.Publish(bus::kStatus, StatusOf("vo", 1.0, 0.5, 10));
  ASSERT_EQ(TakeWith(1).processes.size(), 1U);
  // A status after a change of state comes in between.
  ann_.Publish(bus::kStatus, StatusOf("vo", 1.1, 0.6, 11));
  ann_.Publish(bus::kStatus, StatusOf("vo", 3.0, 1.5, 50));
  const BusLoad load = TakeWith(1, 0.0);
  ASSERT_EQ(load.processes.size(), 1U);
  EXPECT_DOUBLE_EQ(load.processes[0].rate_hz, 20.0);
  EXPECT_DOUBLE_EQ(load.processes[0].cpu_percent, 50.0);
  EXPECT_DOUBLE_EQ(load.processes[0].cpu_ms, 25.0);
}

TEST_F(TopNodeTest, ShowsTheAgeOfEachRobotsPoses) {
  ann_.Publish(bus::kStatus, StatusOf("vo", 1.0, 0.5, 10));
  bob_.Publish(bus::kStatus, StatusOf("vo", 1.0, 0.5, 10));
  for (const double age_ms : {9.0, 300.0, 11.0}) {
    pose_t pose{};
    pose.age_ms = age_ms;
    ann_.Publish(bus::kPose, pose);
  }
  BusLoad load;
  int64_t poses = 0;
  EXPECT_TRUE(Eventually([&] {
    const auto hears = [&](const BusLoad& now) {
      for (const ChannelLoad& channel : now.channels) poses += channel.name == "ann/POSE" && channel.rate_hz > 0.0;
      return now.processes.size() == 2;
    };
    BusLoad now = node_.Take(bus::NowS());
    const bool both = hears(now);
    if (!now.processes.empty() && now.processes[0].age_ms >= 0.0) load = std::move(now);
    return both && poses > 0;
  }));
  ASSERT_FALSE(load.processes.empty());
  EXPECT_EQ(load.processes[0].robot, "ann/");
  EXPECT_GE(load.processes[0].age_ms, 9.0);
  EXPECT_LE(load.processes[0].age_ms, 300.0);
  for (size_t i = 1; i < load.processes.size(); ++i) EXPECT_LT(load.processes[i].age_ms, 0.0);  // no pose of bob's
}

TEST_F(TopNodeTest, CountsTheTrafficOfEachChannel) {
  for (int i = 0; i < 5; ++i) ann_.Publish(bus::kStatus, StatusOf("vo", i, 0.0, i));
  double most_hz = 0.0;
  EXPECT_TRUE(Eventually([&] {
    for (const ChannelLoad& channel : node_.Take(bus::NowS()).channels) {
      if (channel.name == "ann/STATUS") most_hz = std::max(most_hz, channel.rate_hz);
    }
    return most_hz > 0.0;
  }));
}

TEST_F(TopNodeTest, ControlAndInvalidBytesAreEscaped) {
  status_t status = StatusOf("vo", 1.0, 0.5, 10);
  status.reason = "a\x1b[2Jb\xff";
  ann_.Publish(bus::kStatus, status);
  const BusLoad load = TakeWith(1);
  ASSERT_EQ(load.processes.size(), 1U);
  EXPECT_THAT(ToText(load), HasSubstr("a?[2Jb"));
  const auto json = nlohmann::json::parse(ToJson(load));
  EXPECT_EQ(json["processes"][0]["process"], "vo");
  EXPECT_TRUE(json["processes"][0]["rate_hz"].is_null());
}

TEST_F(TopNodeTest, DamagedStatusIsIgnored) {
  const auto good = StatusOf("vo", 1.0, 0.5, 10);
  bus::Transport raw(url_);
  std::vector<uint8_t> bytes = bus::Encoded(good);
  bytes.resize(bytes.size() / 2);
  ASSERT_TRUE(raw.Send("ann/STATUS", bytes));
  bob_.Publish(bus::kStatus, good);
  const BusLoad load = TakeWith(1);
  ASSERT_EQ(load.processes.size(), 1U);
  EXPECT_EQ(load.processes[0].robot, "bob/");
}

}  // namespace
}  // namespace plslam::launcher
