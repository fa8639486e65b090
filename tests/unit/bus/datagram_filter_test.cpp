// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/udp_receiver.h"

#include <gtest/gtest.h>
#include <poll.h>

#include <string>
#include <vector>

#include "core/bus/transport/transport.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using Names = std::set<std::string, std::less<>>;

constexpr size_t kLarge = kUnfilteredBytes + 1000;
constexpr size_t kSmall = 1000;

/// A socket that is filtered, and a sender to it.
class FilteredSocket {
 public:
  void Send(const std::string& channel, size_t size) {
    ASSERT_TRUE(sender_.Send(channel, std::vector<uint8_t>(size)));
  }

  /// What came of what was sent until now, by channel; `END` is sent, and comes always.
  std::vector<std::string> Received() {
    EXPECT_TRUE(sender_.Send("END", std::vector<uint8_t>(1)));
    std::vector<std::string> channels;
    while (channels.empty() || channels.back() != "END") {
      pollfd wait{receiver_.fd(), POLLIN, 0};
      if (poll(&wait, 1, 10'000) != 1) {
        ADD_FAILURE() << "nothing comes";
        break;
      }
      receiver_.Receive([&](std::string_view channel, ByteView) { channels.emplace_back(channel); });
    }
    if (!channels.empty()) channels.pop_back();
    return channels;
  }

  int fd() const { return receiver_.fd(); }

 private:
  std::string url_ = test::PrivateUrl();
  UdpReceiver receiver_{url_};
  Transport sender_{url_};
};

TEST(DatagramFilter, LargeMessagesOfOtherChannelsDoNotReachTheSocket) {
  FilteredSocket socket;
  FilterLargeDatagrams(socket.fd(), {"POSE", "ann/KEYFRAME"});
  for (const char* channel : {"STEREO_FRAME", "POSE", "ann/KEYFRAME", "bob/KEYFRAME"}) socket.Send(channel, kLarge);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"POSE", "ann/KEYFRAME"}));
}

TEST(DatagramFilter, SmallMessagesComeWhateverTheirChannel) {
  FilteredSocket socket;
  FilterLargeDatagrams(socket.fd(), {"POSE"});
  socket.Send("STATUS", kSmall);
  socket.Send("P", kSmall);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"STATUS", "P"}));
}

TEST(DatagramFilter, NamesAreComparedToTheirEnd) {
  // Lengths around those that are compared by words.
  for (size_t length = 1; length <= 63; ++length) {
    const std::string name(length, 'x');
    FilteredSocket socket;
    FilterLargeDatagrams(socket.fd(), {name});
    socket.Send(name, kLarge);
    if (length > 1) socket.Send(name.substr(1), kLarge);
    if (length < 63) socket.Send(name + "x", kLarge);
    socket.Send(name.substr(1) + "y", kLarge);
    EXPECT_EQ(socket.Received(), std::vector<std::string>{name}) << length;
  }
}

TEST(DatagramFilter, TheNextOneTakesItsPlace) {
  FilteredSocket socket;
  FilterLargeDatagrams(socket.fd(), {"A"});
  FilterLargeDatagrams(socket.fd(), {"A", "B"});
  socket.Send("A", kLarge);
  socket.Send("B", kLarge);
  socket.Send("C", kLarge);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"A", "B"}));
  RemoveDatagramFilter(socket.fd());
  socket.Send("C", kLarge);
  EXPECT_EQ(socket.Received(), std::vector<std::string>{"C"});
}

TEST(DatagramFilter, MoreNamesThanTheKernelTakesLetEverythingCome) {
  Names names;
  for (int i = 0; i < 2000; ++i) names.insert("CHANNEL_" + std::to_string(i));
  FilteredSocket socket;
  FilterLargeDatagrams(socket.fd(), {"A"});
  FilterLargeDatagrams(socket.fd(), names);
  socket.Send("B", kLarge);
  EXPECT_EQ(socket.Received(), std::vector<std::string>{"B"});
}

}  // namespace
}  // namespace plslam::bus
