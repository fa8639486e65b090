// SPDX-License-Identifier: BSD-3-Clause
#include <netinet/in.h>
#include <unistd.h>

#include <sys/socket.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/process/order_sender.h"
#include "tools/launch/run_bus.h"

namespace plslam::launcher {
namespace {

/// Returns whether a socket that shares ports, as LCM's do, gets this one.
bool SharerGets(int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  const int yes = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<uint16_t>(port));
  const bool bound = bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(fd);
  return bound;
}

TEST(PrivatePort, TwoAtOnceDiffer) {
  const PrivatePort a, b;
  EXPECT_NE(a.port(), b.port());
  EXPECT_EQ(a.Url(), "udpm://239.255.76.67:" + std::to_string(a.port()) + "?ttl=0");
}

TEST(PrivatePort, CanBeSharedByLcm) {
  const PrivatePort port;
  EXPECT_TRUE(SharerGets(port.port()));
}

TEST(NoAnswerText, NamesUrlPrefixAndRemedy) {
  bus::BusOptions options;
  options.prefix = "team/";
  options.url = "udpm://239.255.76.67:7668?ttl=0";
  EXPECT_THAT(
      bus::NoAnswerText({"mapping"}, options, std::chrono::seconds(10)),
      testing::StartsWith("no process 'mapping' was found on udpm://239.255.76.67:7668?ttl=0 with prefix 'team/' "
                          "within 10 s; give the --url and --prefix"));
  options.url.clear();
  EXPECT_THAT(bus::NoAnswerText({"mapping"}, options, std::chrono::seconds(10)),
              testing::HasSubstr("found on udpm://"))
      << "the default is named, too";
}

}  // namespace
}  // namespace plslam::launcher
