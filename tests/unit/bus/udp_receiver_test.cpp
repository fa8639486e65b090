// SPDX-License-Identifier: BSD-3-Clause
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <unistd.h>

#include <sys/socket.h>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/bus/bus.h"
#include "core/bus/transport/transport.h"
#include "core/bus/transport/udp_receiver.h"
#include "plslam/pose_t.hpp"
#include "plslam/repair_request_t.hpp"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using Names = std::set<std::string, std::less<>>;

constexpr size_t kLarge = kUnfilteredBytes + 1000;
constexpr size_t kSmall = 1000;

/// A socket that is filtered, and a sender to it.
class FilteredSocket {
 public:
  void Send(const std::string& channel, size_t size) { Send(channel, std::vector<uint8_t>(size)); }
  void Send(const std::string& channel, const std::vector<uint8_t>& bytes) {
    ASSERT_TRUE(sender_.Send(channel, bytes));
  }

  void SendInPackets(const std::string& channel, size_t size) {
    ASSERT_TRUE(sender_.SendInPackets(channel, std::vector<uint8_t>(size), 1));
  }

  /// Returns the channels of the messages that were received so far; `END` is sent, and always arrives.
  std::vector<std::string> Received() {
    EXPECT_TRUE(sender_.Send("END", std::vector<uint8_t>(1)));
    std::vector<std::string> channels;
    while (channels.empty() || channels.back() != "END") {
      pollfd wait{receiver_.fd(), POLLIN, 0};
      if (poll(&wait, 1, 10'000) != 1) {
        ADD_FAILURE() << "nothing comes";
        break;
      }
      receiver_.Receive([&](std::string_view channel, ByteView) { channels.emplace_back(channel); },
                        [](uint32_t) { return true; });
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

TEST(DatagramFilter, LargeMessagesOfOtherChannelsAreDropped) {
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"POSE", "ann/KEYFRAME"});
  for (const char* channel : {"STEREO_FRAME", "POSE", "ann/KEYFRAME", "bob/KEYFRAME"}) socket.Send(channel, kLarge);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"POSE", "ann/KEYFRAME"}));
}

TEST(DatagramFilter, SmallMessagesOfAnyChannelPass) {
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"POSE"});
  socket.Send("STATUS", kSmall);
  socket.Send("P", kSmall);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"STATUS", "P"}));
}

TEST(DatagramFilter, UnwantedChannelsAreDroppedAtAnySize) {
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"POSE"}, {}, {"STEREO_FRAME", "TRACKS"});
  for (const char* channel : {"STEREO_FRAME", "STATUS", "TRACKS", "STEREO_FRAME_LIVE", "POSE"}) {
    socket.Send(channel, kSmall);
  }
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"STATUS", "STEREO_FRAME_LIVE", "POSE"}));
}

TEST(DatagramFilter, PartsOfOtherChannelsAreDropped) {
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"POSE", "ann/KEYFRAME"});
  for (const char* channel : {"STEREO_FRAME", "POSE", "ann/KEYFRAME", "bob/KEYFRAME"})
    socket.SendInPackets(channel, kLarge);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"POSE", "ann/KEYFRAME"}));
}

/// A request about a channel to a process.
std::vector<uint8_t> RequestTo(int64_t process, const std::string& channel = "POSE") {
  repair_request_t request{};
  request.channel = channel;
  request.publisher = process;
  return Encoded(request);
}

constexpr int64_t kOwn = 0x123456789abcdef0;

AddressedChannels Requests() { return {{"REPAIR_REQUEST", "map/REPAIR_REQUEST"}, repair_request_t::getHash(), kOwn}; }

/// Returns the number of received messages of two: the given one, and one that always passes.
size_t Come(const std::string& channel, const std::vector<uint8_t>& bytes) {
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"POSE"}, Requests());
  socket.Send(channel, bytes);
  return socket.Received().size();
}

TEST(DatagramFilter, RequestsToOthersAreDropped) {
  for (const char* name : {"REPAIR_REQUEST", "map/REPAIR_REQUEST"}) {
    for (const char* channel : {"", "A", "POSE", "STEREO_FRAME_LIVE"}) {
      EXPECT_EQ(Come(name, RequestTo(kOwn, channel)), 1U) << name << " about " << channel;
      EXPECT_EQ(Come(name, RequestTo(0, channel)), 1U) << name << " about " << channel;
      for (const int64_t other : {kOwn + 1, kOwn - (int64_t{1} << 40), int64_t{1}, int64_t{1} << 33}) {
        EXPECT_EQ(Come(name, RequestTo(other, channel)), 0U) << name << " about " << channel << " to " << other;
      }
    }
  }
  EXPECT_EQ(Come("other/REPAIR_REQUEST", RequestTo(1)), 1U) << "of another prefix";
}

TEST(DatagramFilter, MalformedRequestsPassToBeRejected) {
  const std::vector<uint8_t> whole = RequestTo(1);
  for (size_t size = 0; size < whole.size(); ++size) {
    const bool has_process = size >= kWireHeaderBytes + 4 + 5 + 8;
    const std::vector<uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(Come("REPAIR_REQUEST", cut), has_process ? 0U : 1U) << size;
  }
  for (const size_t at : {size_t{0}, size_t{7}, kWireHeaderBytes, kWireHeaderBytes + 3}) {
    std::vector<uint8_t> other = whole;
    other[at] = 0xff;
    EXPECT_EQ(Come("REPAIR_REQUEST", other), 1U) << "of another version, or longer than names are: " << at;
  }
}

TEST(DatagramFilter, NamesAreComparedToTheirEnd) {
  // Lengths around those that are compared by words.
  for (size_t length = 1; length <= 63; ++length) {
    const std::string name(length, 'x');
    FilteredSocket socket;
    FilterDatagrams(socket.fd(), {name});
    socket.Send(name, kLarge);
    if (length > 1) socket.Send(name.substr(1), kLarge);
    if (length < 63) socket.Send(name + "x", kLarge);
    socket.Send(name.substr(1) + "y", kLarge);
    EXPECT_EQ(socket.Received(), std::vector<std::string>{name}) << length;
  }
}

TEST(DatagramFilter, NewFilterReplacesTheOldOne) {
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"A"});
  FilterDatagrams(socket.fd(), {"A", "B"});
  socket.Send("A", kLarge);
  socket.Send("B", kLarge);
  socket.Send("C", kLarge);
  EXPECT_EQ(socket.Received(), (std::vector<std::string>{"A", "B"}));
  RemoveDatagramFilter(socket.fd());
  socket.Send("C", kLarge);
  EXPECT_EQ(socket.Received(), std::vector<std::string>{"C"});
}

TEST(DatagramFilter, TooManyNamesForTheKernelDisableTheFilter) {
  Names names;
  for (int i = 0; i < 2000; ++i) names.insert("CHANNEL_" + std::to_string(i));
  FilteredSocket socket;
  FilterDatagrams(socket.fd(), {"A"});
  FilterDatagrams(socket.fd(), names);
  socket.Send("B", kLarge);
  EXPECT_EQ(socket.Received(), std::vector<std::string>{"B"});
}

}  // namespace

namespace {

using test::Eventually;
using Packet = std::vector<uint8_t>;

/// Head of a packet of one message, or of a part of one.
Packet PacketOf(const std::string& magic, const std::string& rest) {
  const std::string text = magic + std::string(4, '\0') + rest;
  return {text.begin(), text.end()};
}

std::string Parsed(const Packet& packet) {
  std::string_view channel;
  ByteView bytes;
  if (!ParsePacket(packet, &channel, &bytes)) return "junk";
  return std::string(channel) + ":" + std::string(bytes.begin(), bytes.end());
}

TEST(UdpReceiver, SplitsPackets) {
  using std::string_literals::operator""s;
  EXPECT_EQ(Parsed(PacketOf("LC02", "POSE\0abc"s)), "POSE:abc");
  EXPECT_EQ(Parsed(PacketOf("LC02", "POSE\0"s)), "POSE:");
  EXPECT_EQ(Parsed(PacketOf("LC02", "\0abc"s)), ":abc");
  EXPECT_EQ(Parsed(PacketOf("LC02", "POSE")), "junk") << "the name does not end";
  EXPECT_EQ(Parsed(PacketOf("LC02", "")), "junk");
  EXPECT_EQ(Parsed(PacketOf("LC03", "POSE\0abc"s)), "junk") << "a part of a longer message";
  EXPECT_EQ(Parsed({}), "junk");
  const std::string longest(63, 'x');
  EXPECT_EQ(Parsed(PacketOf("LC02", longest + "\0a"s)), longest + ":a");
  EXPECT_EQ(Parsed(PacketOf("LC02", longest + "x\0a"s)), "junk") << "longer than LCM's names may be";
}

TEST(UdpReceiver, ReadsUrlsAsLcmDoes) {
  const UdpGroup all = ParseUdpGroup("udpm://239.1.2.3:4567?ttl=1&recv_buf_size=1000&x=y");
  EXPECT_EQ(all.address, "239.1.2.3");
  EXPECT_EQ(all.port, 4567);
  EXPECT_EQ(all.buffer_bytes, 1000);
  EXPECT_EQ(ParseUdpGroup("udpm://").address, "239.255.76.67");
  EXPECT_EQ(ParseUdpGroup("udpm://?ttl=1").port, 7667);
  EXPECT_EQ(ParseUdpGroup("udpm://239.1.2.3").port, 7667);
  for (const char* url :
       {"udpm://239.1.2.3:x", "udpm://239.1.2.3:99999", "tcpq://a:1", "udpm://:1?recv_buf_size=z"}) {
    EXPECT_THROW(ParseUdpGroup(url), std::runtime_error) << url;
  }
  EXPECT_THAT(
      [] { UdpReceiver("udpm://10.0.0.1:7667"); },
      testing::ThrowsMessage<std::runtime_error>(
          "bus.url: udpm://10.0.0.1:7667: '10.0.0.1' is not a multicast group (224.0.0.0 to 239.255.255.255)"));
}

/// Sends packets to the group of a URL.
class Sender {
 public:
  explicit Sender(const UdpGroup& group) : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(group.port);
    inet_pton(AF_INET, group.address.c_str(), &to_.sin_addr);
    const unsigned char ttl = 0;
    setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  }
  ~Sender() { close(fd_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;

  void Send(const Packet& packet) const {
    sendto(fd_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
  }

 private:
  int fd_;
  sockaddr_in to_{};
};

/// LCM 1.3.1's own receiver does not survive these.
TEST(UdpReceiver, ForgedPartsOfLongMessagesAreJunk) {
  BusOptions options;
  options.url = test::PrivateUrl();
  test::Waiter received;
  test::RunningBus reader(options, "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  const Sender sender(ParseUdpGroup(options.url));
  std::mt19937_64 random(1);
  for (int i = 0; i < 2000; ++i) {
    std::string part;  // size, offset, part and parts, and a name that does not end
    for (int n = 0; n < 12; ++n) part += static_cast<char>(n == 9 ? 0 : random() % 3);
    part += i % 2 == 0 ? "POSE" : std::string(random() % 100, 'x');
    sender.Send(PacketOf("LC03", part));
  }
  ASSERT_TRUE(Eventually([&] { return reader->counters().rejected > 1000; })) << reader->counters().rejected;
  Bus publisher(options, "publisher");
  publisher.Publish(kPose, pose_t{});
  EXPECT_TRUE(received.Reaches(1));
}

}  // namespace
}  // namespace plslam::bus
