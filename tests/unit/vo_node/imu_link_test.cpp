// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/imu_link.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "core/bus/run_loop.h"
#include "plslam/imu_t.hpp"
#include "plslam/warning_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::vo {
namespace {

constexpr int64_t kPeriod_ns = 50'000'000, kSamplePeriod_ns = 5'000'000;

/// Samples at a constant rate, at both ends, too.
std::vector<ImuSample> SamplesBetween(int64_t from_ns, int64_t to_ns) {
  std::vector<ImuSample> samples;
  for (int64_t t = from_ns; t <= to_ns; t += kSamplePeriod_ns) samples.push_back({.t_ns = t});
  return samples;
}

/// A tracker's link on the test's thread, and a player on another.
class Link : public testing::Test {
 protected:
  explicit Link(double partner_wait_s = 15.0) : process_{"vo", Options(url_, partner_wait_s)} { player_.Start(); }
  ~Link() override { player_.Join(); }
  static bus::BusOptions Options(const std::string& url, double partner_wait_s = 15.0) {
    bus::BusOptions options;
    options.url = url;
    options.partner_wait_s = partner_wait_s;
    return options;
  }
  /// Runs until the frame need not wait any more.
  void RunUntilDone(int64_t prev_t_ns, int64_t t_ns, SourceId source) {
    const auto check = [&, prev_t_ns, t_ns, source] {
      if (!link_->Awaits(source, prev_t_ns, t_ns, true, bus::NowS())) process_.bus().Stop();
    };
    check_ = check;
    process_.bus().Run();
  }

  const std::string url_ = bus::test::PrivateUrl();
  bus::test::RunningBus player_{Options(url_), "player"};
  bus::Process process_;
  std::function<void()> check_;
  std::optional<ImuLink> link_;
};

class ImpatientLink : public Link {
 protected:
  ImpatientLink() : Link(0.05) {}
};

TEST_F(ImpatientLink, MissingSamplesAreReportedOnce) {
  std::mutex mutex;
  std::vector<std::string> codes;
  bus::test::RunningBus listener(Options(url_), "listener");
  listener->Subscribe<warning_t>(bus::kWarning, [&](const warning_t& message) {
    const std::lock_guard lock(mutex);
    codes.push_back(message.code);
  });
  listener.Start();
  link_.emplace(process_, ImuUseOptions(), [&] { check_(); });
  RunUntilDone(0, kPeriod_ns, 7);
  EXPECT_FALSE(link_->Awaits(7, kPeriod_ns, 2 * kPeriod_ns, true, bus::NowS())) << "it waits only once";
  EXPECT_TRUE(bus::test::Eventually([&] {
    const std::lock_guard lock(mutex);
    return !codes.empty();
  }));
  listener.Join();
  EXPECT_THAT(codes, testing::ElementsAre("imu_missing"));
}

TEST_F(Link, FrameWaitsForItsSamples) {
  std::atomic<int64_t> source = 0;
  link_.emplace(process_, ImuUseOptions{}, [&] { check_(); });
  process_.bus().Subscribe<imu_t>(bus::kImu, [&](const imu_t& message) { source = message.header.source; });
  bus::PublishImu(*player_, 0, kPeriod_ns, SamplesBetween(0, kPeriod_ns + kSamplePeriod_ns));
  check_ = [&] {
    if (source != 0 && !link_->Awaits(SourceId(source.load()), 0, kPeriod_ns, true, bus::NowS()))
      process_.bus().Stop();
  };
  process_.bus().Run();
  const std::vector<ImuSample> taken = link_->Take(0, kPeriod_ns, 0);
  ASSERT_EQ(taken.size(), 11U);
  EXPECT_EQ(taken.front().t_ns, 0);
  EXPECT_EQ(taken.back().t_ns, kPeriod_ns) << "one at or after the frame ends the interval";
  EXPECT_TRUE(link_->Awaits(SourceId(source.load()), kPeriod_ns, 2 * kPeriod_ns, true, bus::NowS()));
}

TEST_F(Link, LateSamplesAreThoseOfAnEarlierMotion) {
  std::atomic<int64_t> source = 0;
  link_.emplace(process_, ImuUseOptions{}, [&] { check_(); });
  process_.bus().Subscribe<imu_t>(bus::kImu, [&](const imu_t& message) { source = message.header.source; });
  int64_t n_frames = 0;
  check_ = [&] {
    const int64_t prev_t_ns = n_frames * kPeriod_ns, t_ns = prev_t_ns + kPeriod_ns;
    if (source == 0 || link_->Awaits(SourceId(source.load()), prev_t_ns, t_ns, true, bus::NowS())) return;
    if (++n_frames == 2) return process_.bus().Stop();
    EXPECT_EQ(link_->Take(0, kPeriod_ns, 0).back().t_ns, kPeriod_ns / 2);
    bus::PublishImu(*player_, 0, 2 * kPeriod_ns, SamplesBetween(0, 2 * kPeriod_ns));
  };
  bus::PublishImu(*player_, 0, kPeriod_ns, SamplesBetween(0, kPeriod_ns / 2));
  process_.bus().Run();
  const std::vector<ImuSample> taken = link_->Take(0, 2 * kPeriod_ns, 0);
  ASSERT_FALSE(taken.empty());
  EXPECT_EQ(taken.front().t_ns, 0);
  EXPECT_EQ(taken.size(), 21U);
}

}  // namespace
}  // namespace plslam::vo
