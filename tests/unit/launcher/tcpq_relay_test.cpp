// SPDX-License-Identifier: BSD-3-Clause
#include "tools/launch/relay/tcpq_relay.h"

#include <array>
#include <filesystem>

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include "core/bus/bus.h"
#include "core/bus/logs/log_reader.h"
#include "core/bus/transport/transport.h"
#include "plslam/pose_t.hpp"
#include "tests/unit/bus/bus_fixture.h"
#include "tools/launch/relay/tcpq_client.h"

namespace plslam::bus {
namespace {

using test::Eventually;
using test::RunningBus;
using test::Waiter;

class RunningRelay {
 public:
  RunningRelay() : relay_(0), thread_([this] { relay_.Run(); }) {}
  ~RunningRelay() {
    relay_.Stop();
    thread_.join();
  }
  TcpqRelay& operator*() { return relay_; }
  TcpqRelay* operator->() { return &relay_; }

  BusOptions Options() const {
    BusOptions options;
    options.url = relay_.url();
    return options;
  }

 private:
  TcpqRelay relay_;
  std::thread thread_;
};

/// A bare TCP connection to the relay.
class RawClient {
 public:
  explicit RawClient(int port) : fd_(socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    name.sin_port = htons(static_cast<uint16_t>(port));
    name.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(connect(fd_, reinterpret_cast<const sockaddr*>(&name), sizeof(name)), 0);
  }
  ~RawClient() { close(fd_); }

  void Word(uint32_t word) {
    const uint32_t big = htonl(word);
    Bytes(&big, 4);
  }
  void Bytes(const void* data, size_t n) { send(fd_, data, n, MSG_NOSIGNAL); }
  void SendHello() {
    Word(0x287617fb);
    Word(0x0100);
  }
  void Subscribe(const std::string& pattern) {
    Word(2);
    Word(static_cast<uint32_t>(pattern.size()));
    Bytes(pattern.data(), pattern.size());
  }
  /// Takes at most n of the bytes that are there.
  void Sip(size_t n) {
    std::vector<uint8_t> bytes(n);
    if (recv(fd_, bytes.data(), n, MSG_DONTWAIT) < 0) return;
  }
  /// Receives until n bytes have arrived or the connection ends.
  std::vector<uint8_t> Receive(size_t n) {
    std::vector<uint8_t> bytes(n);
    const ssize_t got = recv(fd_, bytes.data(), n, MSG_WAITALL);
    bytes.resize(got < 0 ? 0 : static_cast<size_t>(got));
    return bytes;
  }

 private:
  int fd_;
};

TEST(TcpqRelay, CarriesOrderedMessagesBetweenProcesses) {
  RunningRelay relay;
  Waiter received;
  int64_t next = 0;
  RunningBus reader(relay.Options(), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, next++);
    received.Add();
  });
  reader.Start();
  Bus publisher(relay.Options(), "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kPose, 1));
  for (int i = 0; i < 1000; ++i) {
    pose_t pose{};
    pose.frame_id = i;
    publisher.Publish(kPose, pose);
  }
  ASSERT_TRUE(received.Reaches(1000)) << received.value();
  EXPECT_EQ(relay->counters().dropped, 0);
}

TEST(TcpqRelay, StockLoggerRecordsThroughIt) {
  if (!test::HasProgram("lcm-logger")) GTEST_SKIP() << "lcm-logger is not installed";
  RunningRelay relay;
  const test::TemporaryFolder folder;
  const std::string log = folder / "log";
  const std::string pid_file = folder / "pid";
  ASSERT_EQ(test::Shell("lcm-logger -q -f --lcm-url=" + relay->url() + " " + log + " > " + (folder / "out") +
                        " 2>&1 & echo $! > " + pid_file),
            0);
  ASSERT_TRUE(Eventually([&] { return relay->counters().clients == 1; }));
  {
    Bus publisher(relay.Options(), "publisher");
    ASSERT_TRUE(Eventually([&] {  // until the logger's subscription is in force
      publisher.Publish(kPose, pose_t{});
      return std::filesystem::exists(log) && publisher.counters().sent >= 100;
    }));
  }
  test::Shell("sleep 0.3; kill -INT $(cat " + pid_file + "); sleep 0.2");
  LogReader reader(log);
  int poses = 0;
  while (const auto event = reader.Next()) poses += event->channel == "POSE" ? 1 : 0;
  EXPECT_GT(poses, 10);
}

/// Publishes 100 MB past `slow`, a client that subscribes to all and does as it likes.
void ExpectNoClientIsStalledBy(RunningRelay& relay, RawClient& slow) {
  slow.SendHello();
  slow.Subscribe(".*");
  Transport reader(relay->url());
  Waiter received;
  reader.SetReceiver([&](std::string_view, ByteView) { received.Add(); });
  reader.Listen("X");
  std::atomic<bool> stop = false;
  std::thread receiving([&] {
    while (!stop) reader.Receive(50);
  });
  Transport publisher(relay->url());
  const std::vector<uint8_t> megabyte(1'000'000, 7);
  ASSERT_TRUE(Eventually([&] {
    publisher.Send("X", std::vector<uint8_t>(10));
    return received.value() > 0;
  }));
  const int64_t before = received.value();
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) publisher.Send("X", megabyte);
  EXPECT_TRUE(received.Reaches(before + 100));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_LT(seconds, std::chrono::duration<double>(plslam::test::Patience(std::chrono::seconds(5))).count());
  EXPECT_GT(relay->counters().dropped, 0);
  stop = true;
  receiving.join();
}

TEST(TcpqRelay, SleepingReaderDoesNotStallTheOthersForLong) {
  RunningRelay relay;
  RawClient sleeper(relay->port());
  ExpectNoClientIsStalledBy(relay, sleeper);
}

TEST(TcpqRelay, SlowReaderDoesNotStallTheOthersForLong) {
  RunningRelay relay;
  RawClient slow(relay->port());
  std::atomic<bool> stop = false;
  std::thread sipping([&] {
    while (!stop) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      slow.Sip(10'000);
    }
  });
  ExpectNoClientIsStalledBy(relay, slow);
  stop = true;
  sipping.join();
}

TEST(TcpqRelay, MalformedClientsAreDisconnected) {
  RunningRelay relay;
  RawClient http(relay->port());
  http.Bytes("GET / HTTP/1.1\r\n\r\n", 18);
  EXPECT_TRUE(http.Receive(1).empty());
  RawClient liar(relay->port());
  liar.SendHello();
  EXPECT_EQ(liar.Receive(8).size(), 8U);
  for (const uint32_t word : {1U, 1U}) liar.Word(word);
  liar.Bytes("X", 1);
  liar.Word(0xFFFFFFFF);
  EXPECT_TRUE(liar.Receive(1).empty());
  EXPECT_TRUE(Eventually([&] { return relay->counters().malformed == 2 && relay->counters().clients == 0; }));
}

TEST(TcpqRelay, TakenPortIsOneSentence) {
  const TcpqRelay first(0);
  try {
    const TcpqRelay second(first.port());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("cannot listen there"), std::string::npos) << error.what();
  }
  EXPECT_THROW(TcpqRelay(0, "no address"), std::runtime_error);
}

TEST(ChannelPattern, MatchesWholeNames) {
  EXPECT_TRUE(ChannelPattern(".*").Matches("POSE"));
  EXPECT_TRUE(ChannelPattern("POSE").Matches("POSE"));
  EXPECT_FALSE(ChannelPattern("POSE").Matches("POSES"));
  EXPECT_TRUE(ChannelPattern("POSE|TRACKS").Matches("TRACKS"));
  EXPECT_FALSE(ChannelPattern("POSE|TRACKS").Matches("XTRACKS"));
  EXPECT_TRUE(ChannelPattern("robot[.]1/POSE").Matches("robot.1/POSE"));
  EXPECT_FALSE(ChannelPattern("(a+)\\1").Matches("aa"));
  EXPECT_FALSE(ChannelPattern("a{1000}{1000}").Matches("a"));
  EXPECT_FALSE(ChannelPattern("(").Matches("("));
}

TEST(MulticastWorks, ReportsTheReason) {
  std::string reason;
  EXPECT_FALSE(MulticastWorks("udpm://127.0.0.1:7667", &reason));
  EXPECT_NE(reason.find("is not a multicast group"), std::string::npos) << reason;
  EXPECT_FALSE(MulticastWorks("tcpq://127.0.0.1:7700", &reason));
  EXPECT_TRUE(MulticastWorks(test::PrivateUrl(), &reason)) << reason;
}

}  // namespace
}  // namespace plslam::bus
