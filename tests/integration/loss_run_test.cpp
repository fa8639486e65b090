// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chrono>
#include <iostream>

#include "tests/integration/by_hand.h"
#include "tests/integration/recorded_run.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"
#include "tests/support/lossy_lan.h"

namespace plslam {
namespace {

using test::ByHand;
using test::LossyLan;
using test::StatusListener;
using test::WholeRun;

constexpr int kLossyFrames = 60;
constexpr const char* kLossyWorld = "synthetic:room?frames=60&size=376x240";
constexpr const char* kLossyUrl = "udpm://239.255.76.67:7667?ttl=1";

/// Results of a run.
struct LossyOutcome {
  test::RecordedRun log;
  std::string trajectory, keyframes, map;
  double seconds = 0.0;
};

template <class Run>
LossyOutcome OutcomeOf(const Run& run, double seconds) {
  return {test::ReadRecordedRun(run.log()), run.Read("trajectory.tum"), run.Read("keyframes.tum"),
          run.Read("map.ply"), seconds};
}

/// All on this machine, by `plslam run`.
void PlayHere(const std::vector<std::string>& options, LossyOutcome* outcome) {
  WholeRun run;
  std::vector<std::string> arguments = {"run", kLossyWorld, "--record", run.log()};
  arguments.insert(arguments.end(), options.begin(), options.end());
  ASSERT_EQ(run.Run(arguments), 0) << run.Logs();
  *outcome = OutcomeOf(run, run.Summary()["wall_s"]);
}

/// Each process on a separate host, with these options for all.
void PlayOver(const LossyLan& lan, const std::vector<std::string>& options_of_all, LossyOutcome* outcome) {
  ByHand run(kLossyUrl);
  run.SetCommon(options_of_all);
  bus::BusOptions options;
  options.url = kLossyUrl;
  StatusListener listener(lan.host(5), options);
  ASSERT_NO_FATAL_FAILURE(run.StartAll({.viewer = &lan.host(1),
                                        .mapping = &lan.host(2),
                                        .loop = &lan.host(3),
                                        .vo = &lan.host(4),
                                        .recorder = &lan.host(0)},
                                       &listener));
  const auto began = std::chrono::steady_clock::now();
  run.StartPlayer(lan.host(5), kLossyWorld);
  ASSERT_TRUE(listener.WaitForFrame(kLossyFrames - 1, 200)) << run.Logs();
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - began;
  ASSERT_NO_FATAL_FAILURE(run.WaitUntilPlayed(&listener));
  EXPECT_TRUE(run.StopAll()) << run.Logs();
  *outcome = OutcomeOf(run, took.count());
}

/// One packet a message, and waits that last longer than any repair.
const std::vector<std::string> kPatientPackets = {"--set", "bus.max_message_bytes=1200", "--set",
                                                  "bus.partner_wait_s=60"};

/// Percent of packets dropped, and as many doubled, and as many that overtake; all others are 1 ms late.
class LossyRun : public testing::TestWithParam<int> {};

TEST_P(LossyRun, GivesTheSameBits) {
  const int percent = GetParam();
  if (percent != 5) {
    PLSLAM_REQUIRE_LONG_TESTS();
  }
  const std::string obstacle = LossyLan::Obstacle();
  LossyOutcome whole, lossy;
  const double share = percent / 100.0;
  if (obstacle.empty()) {
    const LossyLan lan(6, {share, share, share, std::chrono::milliseconds(1)});
    ASSERT_NO_FATAL_FAILURE(PlayOver(lan, kPatientPackets, &lossy));
    std::cout << fmt::format("{} packets delivered, {} lost\n", lan.delivered(), lan.lost());
    EXPECT_EQ(lan.lost() > 0, percent > 0);
  } else {
    std::cout << "no network of our own (" << obstacle
              << "): datagrams are dropped within the processes, not doubled nor delayed\n";
    ASSERT_NO_FATAL_FAILURE(PlayHere({"--set", fmt::format("bus.drop_fraction={}", share)}, &lossy));
  }
  ASSERT_NO_FATAL_FAILURE(PlayHere({}, &whole));
  std::cout << fmt::format("{} % lost, doubled, overtaking: {:.1f} frames/s; on one undisturbed machine {:.1f}\n",
                           percent, kLossyFrames / lossy.seconds, kLossyFrames / whole.seconds);
  EXPECT_EQ(lossy.log.Count("POSE"), kLossyFrames);
  EXPECT_GE(lossy.log.sequence_numbers.size(), 4U);
  for (const auto& [key, numbers] : lossy.log.sequence_numbers) {
    EXPECT_EQ(lossy.log.Gaps(key.first), 0) << key.first;
  }
  EXPECT_EQ(whole.trajectory, lossy.trajectory);
  EXPECT_EQ(whole.keyframes, lossy.keyframes);
  EXPECT_TRUE(whole.map == lossy.map);
  EXPECT_TRUE(whole.log.map_bytes == lossy.log.map_bytes);
  EXPECT_TRUE(whole.log.poses == lossy.log.poses);
}

/// Per mille of the packets dropped. The configuration is the default, in which a message is up to 41 packets.
class LossyDefault : public testing::TestWithParam<int> {};

TEST_P(LossyDefault, TakesAtMostTwiceTheTime) {
  const std::string obstacle = LossyLan::Obstacle();
  if (!obstacle.empty()) GTEST_SKIP() << "no network of our own: " << obstacle;
  if (GetParam() != 30) {
    PLSLAM_REQUIRE_LONG_TESTS();
  }
  LossyOutcome whole, lossy;
  {
    const LossyLan lan(6, {.delay = std::chrono::milliseconds(1)});
    ASSERT_NO_FATAL_FAILURE(PlayOver(lan, {}, &whole));
  }
  const LossyLan lan(6, {.lost = GetParam() / 1000.0, .delay = std::chrono::milliseconds(1)});
  ASSERT_NO_FATAL_FAILURE(PlayOver(lan, {}, &lossy));
  std::cout << fmt::format("{} of {} packets lost: {:.2f} s instead of {:.2f}\n", lan.lost(),
                           lan.lost() + lan.delivered(), lossy.seconds, whole.seconds);
  EXPECT_GT(lan.lost(), 0);
  EXPECT_LE(lossy.seconds, 2.0 * whole.seconds);
  EXPECT_EQ(whole.trajectory, lossy.trajectory);
  EXPECT_EQ(whole.keyframes, lossy.keyframes);
  EXPECT_TRUE(whole.map == lossy.map);
  EXPECT_TRUE(whole.log.poses == lossy.log.poses);
}

INSTANTIATE_TEST_SUITE_P(PerMille, LossyDefault, testing::Values(1, 10, 30));
INSTANTIATE_TEST_SUITE_P(Percent, LossyRun, testing::Values(0, 1, 5, 20));

}  // namespace
}  // namespace plslam
