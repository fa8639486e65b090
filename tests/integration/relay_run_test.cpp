// SPDX-License-Identifier: BSD-3-Clause
#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <filesystem>
#include <iostream>

#include "tests/integration/by_hand.h"
#include "tests/integration/recorded_run.h"
#include "tests/integration/whole_run.h"
#include "tests/support/long_tests.h"
#include "tests/support/network_host.h"
#include "tools/launch/child_process.h"

namespace plslam::launcher {
namespace {

using test::ByHand;
using test::Lan;
using test::NetworkHost;
using test::StatusListener;
using test::WholeRun;

constexpr int kRelayedFrames = 60;
const std::string kRelayedWorld = fmt::format("synthetic:room?frames={}&size=376x240", kRelayedFrames);

/// Path in LCM's Java package (Debian: liblcm-java).
constexpr const char* kJar = "/usr/share/java/lcm.jar";

std::filesystem::path FindJava() {
  for (const char* path : {"/usr/bin/java", "/usr/local/bin/java"}) {
    if (std::filesystem::exists(path)) return path;
  }
  return "";
}

/// A socket at any free port of this machine, or connected to one.
class LocalSocket {
 public:
  LocalSocket() : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {}
  ~LocalSocket() { close(fd_); }
  LocalSocket(const LocalSocket&) = delete;
  LocalSocket& operator=(const LocalSocket&) = delete;

  int Bind() {
    sockaddr_in name = Address(0);
    socklen_t length = sizeof name;
    auto* bare = reinterpret_cast<sockaddr*>(&name);
    if (bind(fd_, bare, length) != 0 || getsockname(fd_, bare, &length) != 0) return 0;
    return ntohs(name.sin_port);
  }
  bool Connect(int port) {
    const sockaddr_in name = Address(port);
    return connect(fd_, reinterpret_cast<const sockaddr*>(&name), sizeof name) == 0;
  }

 private:
  static sockaddr_in Address(int port) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(static_cast<uint16_t>(port));
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    return name;
  }

  int fd_;
};

void ExpectSameRun(const WholeRun& expected, const WholeRun& run) {
  const auto a = test::ReadRecordedRun(expected.log()), b = test::ReadRecordedRun(run.log());
  EXPECT_EQ(run.Summary()["tracked_frames"], kRelayedFrames);
  for (const auto& [key, numbers] : b.sequence_numbers) EXPECT_EQ(b.Gaps(key.first), 0) << key.first;
  EXPECT_EQ(expected.Read("trajectory.tum"), run.Read("trajectory.tum"));
  EXPECT_TRUE(expected.Read("map.ply") == run.Read("map.ply"));
  EXPECT_TRUE(a.map_bytes == b.map_bytes);
}

TEST(Relay, LcmJavaRelayCarriesARun) {
  const std::filesystem::path java = FindJava();
  if (java.empty() || !std::filesystem::exists(kJar)) GTEST_SKIP() << "needs java and " << kJar << " (liblcm-java)";
  WholeRun direct, relayed;
  const int port = LocalSocket().Bind();
  ASSERT_GT(port, 0);
  ChildProcess relay(java, {"-cp", kJar, "lcm.lcm.TCPService", std::to_string(port)}, relayed.folder() / "relay.log");
  ASSERT_TRUE(WholeRun::WaitFor([&] { return LocalSocket().Connect(port); }));
  ASSERT_EQ(direct.Run({"run", kRelayedWorld, "--record", direct.log()}), 0) << direct.Logs();
  ASSERT_EQ(relayed.Run(
                {"run", kRelayedWorld, "--record", relayed.log(), "--url", fmt::format("tcpq://127.0.0.1:{}", port)}),
            0)
      << relayed.Logs();
  std::cout << fmt::format("{} s through LCM's relay, {} s by multicast\n", relayed.Summary()["wall_s"].dump(),
                           direct.Summary()["wall_s"].dump());
  ExpectSameRun(direct, relayed);
}

/// Our own relay, on one of three machines without multicast between them.
TEST(Relay, JoinsMachinesWithoutMulticast) {
  PLSLAM_REQUIRE_LONG_TESTS();
  if (!NetworkHost::Obstacle().empty()) GTEST_SKIP() << NetworkHost::Obstacle();
  const Lan lan(3);
  for (int i = 0; i < 3; ++i) lan.host(i).Shell("ip route del 224.0.0.0/4 dev eth0");
  const std::string url = "tcpq://10.77.0.2:7700";
  ByHand relay("unused"), run(url);
  lan.host(1).Do([&] { relay.StartPlain("plslam", {"relay", "--address", "0.0.0.0"}); });
  ASSERT_TRUE(WholeRun::WaitFor([&] { return relay.Logs().find("relaying at") != std::string::npos; }));
  bus::BusOptions options;
  options.url = url;
  StatusListener listener(lan.host(0), options);
  ASSERT_NO_FATAL_FAILURE(run.StartAll(
      {.viewer = &lan.host(2), .mapping = &lan.host(1), .loop = &lan.host(1), .vo = &lan.host(0)}, &listener));
  run.StartPlayer(lan.host(0), kRelayedWorld);
  ASSERT_NO_FATAL_FAILURE(run.WaitUntilPlayed(&listener));
  EXPECT_TRUE(run.StopAll()) << run.Logs();
  WholeRun single;
  ASSERT_EQ(single.Run({"run", kRelayedWorld}), 0) << single.Logs();
  EXPECT_EQ(run.Read("trajectory.tum"), single.Read("trajectory.tum"));
  EXPECT_TRUE(run.Read("map.ply") == single.Read("map.ply"));
}

}  // namespace
}  // namespace plslam::launcher
