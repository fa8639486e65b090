// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <iostream>
#include <thread>

#include "tests/integration/by_hand.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"
#include "tests/support/network_host.h"

namespace plslam {
namespace {

using test::ByHand;
using test::Lan;
using test::NetworkHost;
using test::StatusListener;
using test::WholeRun;

constexpr const char* kMachinesUrl = "udpm://239.255.76.67:7667?ttl=1";
constexpr int kMachinesFrames = 150;
const std::string kMachinesWorld = fmt::format("synthetic:room?frames={}&size=376x240", kMachinesFrames);

/// Which host each process runs on.
struct Plan {
  int n_hosts;
  int tracking;  ///< player and vo_process
  int mapping;   ///< mapping_process and loop_process
  int viewer;
  int cut;  ///< the host whose cable is disconnected for 5 s; -1: none
};

bus::BusOptions ListenerOptions() {
  bus::BusOptions options;
  options.url = kMachinesUrl;
  return options;
}

/// Pulls the cable in the middle of the run, for less than partners in lockstep wait for one that is out of reach
/// (`bus.partner_wait_s`).
void CutFor5s(const Lan& lan, int host, StatusListener* listener) {
  if (host < 0) return;
  ASSERT_TRUE(listener->WaitForFrame(kMachinesFrames / 3));
  lan.SetLink(host, false);
  std::this_thread::sleep_for(std::chrono::seconds(5));  // the fault itself
  lan.SetLink(host, true);
}

void ExpectTheSameAsOnOneMachine(const ByHand& run) {
  WholeRun single;
  ASSERT_EQ(single.Run({"run", kMachinesWorld}), 0) << single.Logs();
  EXPECT_EQ(single.Summary()["tracked_frames"], kMachinesFrames);
  for (const char* file : {"trajectory.tum", "trajectory_live.tum", "keyframes.tum", "map.ply"}) {
    EXPECT_FALSE(run.Read(file).empty()) << file;
    EXPECT_TRUE(run.Read(file) == single.Read(file)) << file;
  }
}

void PlayOnSeveralMachines(const Plan& plan) {
  if (!NetworkHost::Obstacle().empty()) GTEST_SKIP() << NetworkHost::Obstacle();
  const Lan lan(plan.n_hosts);
  ByHand run(kMachinesUrl);
  // It listens on the player's host: there it receives poses whichever cable is disconnected.
  StatusListener listener(lan.host(plan.tracking), ListenerOptions());
  ASSERT_NO_FATAL_FAILURE(run.StartAll({.viewer = &lan.host(plan.viewer),
                                        .mapping = &lan.host(plan.mapping),
                                        .loop = &lan.host(plan.mapping),
                                        .vo = &lan.host(plan.tracking)},
                                       &listener));
  const auto began = std::chrono::steady_clock::now();
  run.StartPlayer(lan.host(plan.tracking), kMachinesWorld);
  CutFor5s(lan, plan.cut, &listener);
  ASSERT_NO_FATAL_FAILURE(run.WaitUntilPlayed(&listener));
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  std::cout << fmt::format("{} hosts{}: {} frames in {:.1f} s\n", plan.n_hosts,
                           plan.cut >= 0 ? fmt::format(", host {} cut off for 5 s", plan.cut) : "", kMachinesFrames,
                           took.count());
  EXPECT_TRUE(run.StopAll()) << run.Logs();
  ExpectTheSameAsOnOneMachine(run);
}

TEST(Machines, ThreeWithTheMappersCableOutFor5s) { PlayOnSeveralMachines({3, 0, 1, 2, 1}); }

/// All frames are played before the 5 s are over; the player runs until the viewer has received their number.
TEST(Machines, ThreeWithTheViewersCableOutFor5s) { PlayOnSeveralMachines({3, 0, 1, 2, 2}); }

TEST(Machines, Two) {
  PLSLAM_REQUIRE_LONG_TESTS();
  PlayOnSeveralMachines({2, 0, 1, 0, -1});
}

TEST(Machines, ThreeWithTheTrackersCableOutFor5s) {
  PLSLAM_REQUIRE_LONG_TESTS();
  PlayOnSeveralMachines({3, 0, 1, 2, 0});
}

TEST(Machines, OfTwoTrackersThatMeetTheOlderStays) {
  if (!NetworkHost::Obstacle().empty()) GTEST_SKIP() << NetworkHost::Obstacle();
  const Lan lan(2);
  lan.SetLink(1, false);
  ByHand older(kMachinesUrl), younger(kMachinesUrl);
  StatusListener at_older(lan.host(0), ListenerOptions()), at_younger(lan.host(1), ListenerOptions());
  older.Start(lan.host(0), "vo_process");
  // The uptimes decide if they differ by more than 2 s.
  ASSERT_TRUE(at_older.WaitFor([](const auto& statuses, int64_t) {
    const auto vo = statuses.find("vo");
    return vo != statuses.end() && vo->second.uptime_s > 4.0;
  })) << older.Logs();
  younger.Start(lan.host(1), "vo_process");
  ASSERT_TRUE(at_younger.WaitForState("vo", "ready")) << younger.Logs();
  lan.SetLink(1, true);
  EXPECT_EQ(younger.Wait("vo_process", 30), 1);
  EXPECT_NE(younger.Logs().find("another vo is running on this bus"), std::string::npos) << younger.Logs();
  EXPECT_TRUE(older.StopAll()) << older.Logs();
}

// Datagrams that the bus's own filter drops are not lost.
TEST(Machines, DoctorFindsNothingAfterARun) {
  if (!NetworkHost::Obstacle().empty()) GTEST_SKIP() << NetworkHost::Obstacle();
  const std::string url = "udpm://239.255.76.67:7667?ttl=0";
  const NetworkHost host;
  bus::BusOptions options;
  options.url = url;
  ByHand run(url);
  StatusListener listener(host, options);
  ASSERT_NO_FATAL_FAILURE(run.StartAll({.viewer = &host, .mapping = &host, .loop = &host, .vo = &host}, &listener));
  run.StartPlayer(host, "synthetic:room?frames=40&size=376x240");
  ASSERT_NO_FATAL_FAILURE(run.WaitUntilPlayed(&listener));
  run.Start(host, "plslam", {"doctor", "--quiet"});
  run.Wait("plslam");
  EXPECT_EQ(run.Logs().find("buffers were full"), std::string::npos) << run.Logs();
}

}  // namespace
}  // namespace plslam
