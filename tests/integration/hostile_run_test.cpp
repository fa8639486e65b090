// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <optional>

#include "core/bus/logs/log_reader.h"
#include "tests/integration/by_hand.h"
#include "tests/integration/recorded_run.h"
#include "tests/support/hostile_sender.h"
#include "tests/support/key_file.h"
#include "tests/support/long_tests.h"
#include "tests/support/network_host.h"

namespace plslam {
namespace {

using test::ByHand;
using test::HostileSender;
using test::KeyFile;
using test::NetworkHost;
using test::StatusListener;
using testing::HasSubstr;

constexpr const char* kGroup = "239.255.76.67";
constexpr uint16_t kPort = 7667;
constexpr const char* kHostileUrl = "udpm://239.255.76.67:7667?ttl=0";
constexpr int kHostileFrames = 60;
const std::string kHostileWorld = fmt::format("synthetic:room?frames={}&size=376x240", kHostileFrames);

bus::BusOptions ListenerOptions(const std::string& key_file, const std::string& prefix = "") {
  bus::BusOptions options;
  options.url = kHostileUrl;
  options.key_file = key_file;
  options.prefix = prefix;
  return options;
}

/// Results of a run, and the hostile traffic that it received.
struct HostileOutcome {
  test::RecordedRun log;
  std::string trajectory, keyframes, map;
  std::vector<std::vector<uint8_t>> packets;  // as on the wire
  double rejected = 0, duplicates = 0, unproven = 0;
  double peak_mb = 0;
  std::string complaint;
};

std::vector<std::vector<uint8_t>> PacketsOf(const std::string& log, size_t most_bytes) {
  std::vector<std::vector<uint8_t>> packets;
  bus::LogReader reader(log);
  while (const auto event = reader.Next()) {
    const auto bytes = reader.Data(event->data_offset, event->data_bytes);
    if (bytes && bytes->size() <= most_bytes) packets.push_back(HostileSender::Packet(event->channel, *bytes));
  }
  return packets;
}

/// Plays one lockstep run of all processes on `host`, with `hostile` traffic beside it if there is a plan.
void Play(const NetworkHost& host, const std::string& key_file, const std::optional<HostileSender::Plan>& hostile,
          HostileOutcome* outcome) {
  ByHand run(kHostileUrl);
  if (!key_file.empty()) run.SetCommon({"--set", "bus.key_file=" + key_file});
  StatusListener listener(host, ListenerOptions(key_file));
  std::unique_ptr<HostileSender> sender;
  if (hostile) host.Do([&] { sender = std::make_unique<HostileSender>(*hostile); });
  ASSERT_NO_FATAL_FAILURE(
      run.StartAll({.viewer = &host, .mapping = &host, .loop = &host, .vo = &host, .recorder = &host}, &listener));
  run.StartPlayer(host, kHostileWorld);
  ASSERT_NO_FATAL_FAILURE(run.WaitUntilPlayed(&listener));
  for (const auto& [name, status] : listener.statuses()) {
    if (name == "player") continue;
    outcome->rejected += listener.Counter(name, "bus.rejected");
    outcome->duplicates += listener.Counter(name, "bus.duplicates");
    outcome->unproven += listener.Counter(name, "bus.unproven");
    outcome->peak_mb = std::max(outcome->peak_mb, listener.PeakMemory_mb(name));
  }
  outcome->complaint = listener.Reason("mapping");
  if (sender != nullptr) {
    std::cout << fmt::format("{} hostile datagrams, {:.0f} in a second\n", sender->sent(), sender->rate());
    EXPECT_GT(sender->rate(), 0.8 * hostile->per_second);
  }
  sender.reset();
  EXPECT_TRUE(run.StopAll()) << run.Logs();
  outcome->log = test::ReadRecordedRun(run.log());
  outcome->trajectory = run.Read("trajectory.tum");
  outcome->keyframes = run.Read("keyframes.tum");
  outcome->map = run.Read("map.ply");
  outcome->packets = PacketsOf(run.log(), 1400);
}

HostileSender::Plan HostilePlan() {
  HostileSender::Plan plan;
  plan.group = kGroup;
  plan.port = kPort;
  for (const bus::Channel& channel : bus::Channels()) plan.channels.emplace_back(channel.name);
  return plan;
}

void ExpectUnharmed(const HostileOutcome& quiet, const HostileOutcome& attacked) {
  std::cout << fmt::format(
      "rejected {:.0f}, duplicates {:.0f}, of unproven senders {:.0f}; largest process {:.0f} MB, undisturbed {:.0f} "
      "MB; "
      "mapping says: {}\n",
      attacked.rejected, attacked.duplicates, attacked.unproven, attacked.peak_mb, quiet.peak_mb, attacked.complaint);
  EXPECT_EQ(quiet.rejected, 0);
  EXPECT_GT(attacked.rejected, 10'000);
  EXPECT_GT(attacked.duplicates, 500);
  EXPECT_LT(attacked.peak_mb, quiet.peak_mb + 100);
  EXPECT_THAT(attacked.complaint, HasSubstr("messages rejected: "));
  EXPECT_EQ(attacked.log.poses.size(), static_cast<size_t>(kHostileFrames));
  EXPECT_TRUE(quiet.log.poses == attacked.log.poses);
  EXPECT_TRUE(quiet.log.keyframes == attacked.log.keyframes);
  EXPECT_TRUE(quiet.log.map_bytes == attacked.log.map_bytes);
  EXPECT_EQ(quiet.trajectory, attacked.trajectory);
  EXPECT_EQ(quiet.keyframes, attacked.keyframes);
  EXPECT_TRUE(quiet.map == attacked.map);
}

class HostileRun : public testing::Test {
 protected:
  void SetUp() override {
    if (!NetworkHost::Obstacle().empty()) GTEST_SKIP() << NetworkHost::Obstacle();
  }
};

TEST_F(HostileRun, WithAKeyNoForgedMessageIsAccepted) {
  const NetworkHost host;
  const ByHand folder(kHostileUrl);
  const std::string key = KeyFile(folder.folder(), 'a');
  HostileOutcome quiet, attacked;
  ASSERT_NO_FATAL_FAILURE(Play(host, key, std::nullopt, &quiet));
  HostileSender::Plan plan = HostilePlan();
  plan.forge = true;
  plan.recording = quiet.packets;
  ASSERT_GT(plan.recording.size(), 100U);
  ASSERT_NO_FATAL_FAILURE(Play(host, key, plan, &attacked));
  ExpectUnharmed(quiet, attacked);
  EXPECT_GT(attacked.unproven, 100);
}

TEST_F(HostileRun, JunkAndReplaysAreHarmlessWithoutAKey) {
  PLSLAM_REQUIRE_LONG_TESTS();
  const NetworkHost host;
  HostileOutcome quiet, attacked;
  ASSERT_NO_FATAL_FAILURE(Play(host, "", std::nullopt, &quiet));
  ASSERT_NO_FATAL_FAILURE(Play(host, "", HostilePlan(), &attacked));
  ExpectUnharmed(quiet, attacked);
}

/// mapping_process with one key, and next to it one with another, or with another prefix.
TEST_F(HostileRun, OtherKeysAndPrefixesAreOneLineOfStatus) {
  const NetworkHost host;
  ByHand ours(kHostileUrl), other_key(kHostileUrl), no_key(kHostileUrl), other_prefix(kHostileUrl);
  const std::string key = KeyFile(ours.folder(), 'a');
  StatusListener listener(host, ListenerOptions(key));
  ours.Start(host, "mapping_process", {"--set", "bus.key_file=" + key});
  ASSERT_TRUE(listener.WaitForState("mapping", "ready")) << ours.Logs();
  EXPECT_EQ(listener.Reason("mapping"), "");
  other_key.Start(host, "loop_process", {"--set", "bus.key_file=" + KeyFile(ours.folder(), 'b')});
  no_key.Start(host, "vo_process");
  other_prefix.Start(host, "loop_process", {"--prefix", "robot2/"});
  const auto complaint = [&](const std::string& text) {
    return listener.WaitFor([&](const StatusListener::Statuses& statuses, int64_t) {
      const auto found = statuses.find("mapping");
      return found != statuses.end() && found->second.reason.find(text) != std::string::npos;
    });
  };
  EXPECT_TRUE(complaint(" altered or with another bus.key_file (")) << listener.Reason("mapping");
  EXPECT_TRUE(complaint(" without bus.key_file (")) << listener.Reason("mapping");
  EXPECT_TRUE(complaint("processes with prefix 'robot2/' were found, too")) << listener.Reason("mapping");
  for (ByHand* run : {&other_key, &no_key, &other_prefix}) EXPECT_TRUE(run->StopAll()) << run->Logs();
  EXPECT_TRUE(ours.StopAll());
  const std::string log = ours.Logs();
  size_t lines = 0;
  for (size_t at = log.find("was rejected"); at != std::string::npos; at = log.find("was rejected", at + 1)) ++lines;
  EXPECT_EQ(lines, 2U) << "one for each kind, not for each message:\n" << log;
}

}  // namespace
}  // namespace plslam
