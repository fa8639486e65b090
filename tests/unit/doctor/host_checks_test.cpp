// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tools/doctor/host_checks.h"
#include "tools/doctor/multicast_check.h"
#include "tools/doctor/socket_check.h"

namespace plslam::doctor {
namespace {

using testing::HasSubstr;

TEST(BusAddress, ParsesUrls) {
  const BusAddress udp = ParseBusAddress("udpm://239.1.2.3:7700?recv_buf_size=5000&ttl=1");
  EXPECT_EQ(udp.kind, BusAddress::Kind::kMulticast);
  EXPECT_EQ(udp.host, "239.1.2.3");
  EXPECT_EQ(udp.port, 7700);
  EXPECT_EQ(udp.ttl, 1);
  EXPECT_EQ(udp.receive_buffer, 5000);
  const BusAddress bare = ParseBusAddress("udpm://?ttl=0");
  EXPECT_EQ(bare.host, "239.255.76.67");
  EXPECT_EQ(bare.port, 7667);
  const BusAddress relay = ParseBusAddress("tcpq://robot:7701");
  EXPECT_EQ(relay.kind, BusAddress::Kind::kRelay);
  EXPECT_EQ(relay.host, "robot");
  EXPECT_EQ(relay.port, 7701);
  EXPECT_EQ(ParseBusAddress("file:///a.lcm").kind, BusAddress::Kind::kOther);
  EXPECT_THROW(ParseBusAddress("udpm://239.1.2.3:http"), std::runtime_error);
  EXPECT_THROW(ParseBusAddress("udpm://239.1.2.3:7667?ttl=900"), std::runtime_error);
}

constexpr char kTable[] =
    "Iface\tDestination\tGateway \tFlags\tRefCnt\tUse\tMetric\tMask\t\tMTU\tWindow\tIRTT\n"
    "eth0\t00000000\t010200C0\t0003\t0\t0\t0\t00000000\t0\t0\t0\n"
    "eth0\t000200C0\t00000000\t0001\t0\t0\t0\t00FFFFFF\t0\t0\t0\n"
    "wifi\t000000E0\t00000000\t0001\t0\t0\t20\t000000F0\t0\t0\t0\n"
    "lo\t000000E0\t00000000\t0001\t0\t0\t10\t000000F0\t0\t0\t0\n";

TEST(Route, LongestPrefixThenLowestMetric) {
  EXPECT_EQ(RouteDevice(kTable, "239.255.76.67"), "lo");
  EXPECT_EQ(RouteDevice(kTable, "192.0.2.9"), "eth0");
  EXPECT_EQ(RouteDevice(kTable, "10.0.0.1"), "eth0");
  EXPECT_EQ(RouteDevice("Iface\n", "239.255.76.67"), "");
  EXPECT_EQ(RouteDevice("", "239.255.76.67"), "");
  EXPECT_EQ(RouteDevice("Iface\nrubbish\n\n", "239.255.76.67"), "");
  EXPECT_EQ(RouteDevice(kTable, "no address"), "");
}

TEST(Route, MissingAndUnsuitableRoutes) {
  const std::vector<NetworkDevice> devices{{"lo", true, true, false},
                                           {"eth0", true, false, true},
                                           {"tun", true, false, false},
                                           {"off", false, false, true}};
  const BusAddress local = ParseBusAddress("udpm://239.255.76.67:7667?ttl=0");
  const BusAddress wide = ParseBusAddress("udpm://239.255.76.67:7667?ttl=1");
  EXPECT_TRUE(CheckRoute(local, "lo", devices).empty());
  EXPECT_TRUE(CheckRoute(wide, "eth0", devices).empty());
  EXPECT_THAT(CheckRoute(local, "", devices).at(0).mend, HasSubstr("ip route replace 224.0.0.0/4 dev lo"));
  EXPECT_THAT(CheckRoute(wide, "", devices).at(0).mend, HasSubstr("dev eth0"));
  EXPECT_THAT(CheckRoute(wide, "lo", devices).at(0).what, HasSubstr("ttl=1 should reach other machines"));
  EXPECT_THAT(CheckRoute(wide, "lo", devices).at(0).mend, HasSubstr("dev eth0"));
  EXPECT_THAT(CheckRoute(wide, "tun", devices).at(0).mend, HasSubstr("ip link set tun multicast on"));
  EXPECT_THAT(CheckRoute(local, "off", devices).at(0).mend, HasSubstr("ip link set off up"));
}

TEST(UdpTable, PortsInodesAndDrops) {
  const auto sockets = ParseUdpSockets(
      "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer "
      "drops\n"
      "  123: 00000000:1DF3 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 4711 2 "
      "0000000000000000 42\n"
      "rubbish\n");
  ASSERT_EQ(sockets.size(), 1U);
  EXPECT_EQ(sockets[0].port, 7667);
  EXPECT_EQ(sockets[0].inode, 4711);
  EXPECT_EQ(sockets[0].drops, 42);
}

/// A UDP socket with exclusive use of its port.
class Hog {
 public:
  Hog() : fd_(socket(AF_INET, SOCK_DGRAM, 0)) {
    sockaddr_in name{};
    name.sin_family = AF_INET;
    socklen_t length = sizeof name;
    EXPECT_EQ(bind(fd_, reinterpret_cast<sockaddr*>(&name), sizeof name), 0);
    getsockname(fd_, reinterpret_cast<sockaddr*>(&name), &length);
    port = ntohs(name.sin_port);
  }
  ~Hog() { close(fd_); }
  Hog(const Hog&) = delete;
  Hog& operator=(const Hog&) = delete;
  int port = 0;

 private:
  int fd_;
};

TEST(Sockets, BufferErrorsOfTheKernel) {
  EXPECT_EQ(ParseBufferErrors("Ip: Forwarding\nIp: 1\nUdp: InDatagrams NoPorts InErrors OutDatagrams RcvbufErrors\n"
                              "Udp: 500 1 40 600 37\nUdpLite: InDatagrams RcvbufErrors\nUdpLite: 0 9\n"),
            37);
  EXPECT_EQ(ParseBufferErrors(""), 0);
  EXPECT_EQ(ParseBufferErrors("Udp: InDatagrams\nUdp: 500\n"), 0);
}

TEST(Port, UsedByAProgramThatDoesNotShareIt) {
  const Hog hog;
  const Findings findings = CheckPort(ParseBusAddress("udpm://239.255.76.67:" + std::to_string(hog.port)));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].verdict, Verdict::kProblem);
  EXPECT_THAT(findings[0].what, HasSubstr("process " + std::to_string(getpid())));
  EXPECT_THAT(findings[0].mend, HasSubstr("kill " + std::to_string(getpid())));
}

TEST(Port, MissingRelay) {
  const Hog hog;  // a port that is free for TCP
  const Findings findings = CheckPort(ParseBusAddress("tcpq://127.0.0.1:" + std::to_string(hog.port)));
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].verdict, Verdict::kProblem) << findings[0].what;
  EXPECT_THAT(findings[0].mend, HasSubstr("plslam relay --port " + std::to_string(hog.port)));
}

TEST(ReceiveBuffer, MoreThanTheKernelGrants) {
  const Findings little = CheckReceiveBuffer(ParseBusAddress("udpm://239.255.76.67:9?recv_buf_size=4096"));
  EXPECT_EQ(little.at(0).verdict, Verdict::kGood) << little[0].what;
  const Findings much = CheckReceiveBuffer(ParseBusAddress("udpm://239.255.76.67:9?recv_buf_size=1073741824"));
  EXPECT_EQ(much.at(0).verdict, Verdict::kAdvice) << much[0].what;
  EXPECT_THAT(much[0].mend, HasSubstr("sysctl -w net.core.rmem_max=1073741824"));
}

TEST(Clock, StepsAndMissingSynchronisation) {
  const ClockSample begin{1'000'000'000'000, 5'000'000'000};
  const auto after = [&](int64_t wall_ns, int64_t steady_ns) {
    return ClockSample{begin.wall_ns + wall_ns, begin.steady_ns + steady_ns};
  };
  EXPECT_EQ(CheckClock(begin, after(2'000'800'000, 2'000'000'000), true).at(0).verdict, Verdict::kGood);
  EXPECT_EQ(CheckClock(begin, after(2'000'000'000, 2'000'000'000), false).at(0).verdict, Verdict::kAdvice);
  const Findings stepped = CheckClock(begin, after(-3'598'000'000'000, 2'000'000'000), true);
  EXPECT_EQ(stepped.at(0).verdict, Verdict::kProblem);
  EXPECT_THAT(stepped[0].what, HasSubstr("set by -3600.000 s"));
  EXPECT_EQ(CheckClock(SampleClocks(), SampleClocks(), true).at(0).verdict, Verdict::kGood);
}

TEST(Files, NewFolderAndImpossibleFolder) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("doctor" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  EXPECT_NE(CheckFolder(folder / "a" / "b", "outputs", "m").at(0).what.find(folder.string()), std::string::npos);
  std::ofstream(folder / "file") << "x";
  const Findings no_folder = CheckFolder(folder / "file", "outputs", "m");
  EXPECT_EQ(no_folder.at(0).verdict, Verdict::kProblem);
  EXPECT_THAT(no_folder[0].what, HasSubstr("is not a folder"));
  EXPECT_EQ(CheckFolder("/proc/self", "outputs", "m").at(0).verdict, Verdict::kProblem) << "/proc takes no files";
  std::filesystem::remove_all(folder);
}

TEST(Files, VocabularyThatIsMissingOrDamaged) {
  const Findings missing = CheckVocabulary("no.vocabulary", "points", "loop.vocabularies.points");
  EXPECT_EQ(missing.at(0).verdict, Verdict::kProblem);
  EXPECT_THAT(missing[0].mend, HasSubstr("train_vocabulary --kind points"));
  const std::string damaged = testing::TempDir() + "damaged.vocabulary";
  std::ofstream(damaged) << "not a vocabulary";
  EXPECT_EQ(CheckVocabulary(damaged, "points", "k").at(0).verdict, Verdict::kProblem);
  std::filesystem::remove(damaged);
}

}  // namespace
}  // namespace plslam::doctor
