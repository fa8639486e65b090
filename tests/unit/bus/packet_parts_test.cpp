// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/packet_parts.h"

#include <gtest/gtest.h>
#include <lcm/lcm.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/bus/transport/transport.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using Packet = std::vector<uint8_t>;

constexpr const char* kChannel = "STEREO_FRAME";

std::vector<uint8_t> RandomMessage(size_t size, uint32_t seed = 1) {
  std::mt19937 random(seed);
  std::vector<uint8_t> message(size);
  for (uint8_t& byte : message) byte = static_cast<uint8_t>(random());
  return message;
}

std::vector<Packet> PartsOf(const std::vector<uint8_t>& message, int64_t seq, uint32_t attempt) {
  std::vector<Packet> packets;
  ForEachPart(kChannel, message, PartsNumber(kChannel, seq, attempt),
              [&](ByteView packet) { packets.emplace_back(packet.begin(), packet.end()); });
  return packets;
}

std::optional<LongMessages::Message> Add(PacketParts& parts, const Packet& packet, int64_t now = 0,
                                         uint64_t sender = 1) {
  const auto part = ParsePart(packet);
  EXPECT_TRUE(part);
  return part ? parts.Add(sender, *part, now) : std::nullopt;
}

TEST(PacketParts, AnySizeInAnyOrder) {
  std::mt19937 random(5);
  for (const size_t size : {1UL, 1186UL, 1187UL, 1188UL, 2387UL, 2388UL, 60'000UL}) {
    const auto message = RandomMessage(size);
    std::vector<Packet> packets = PartsOf(message, 7, 0);
    for (const Packet& packet : packets) EXPECT_LE(packet.size(), 1472U) << "the room in a packet of 1,500 bytes";
    std::shuffle(packets.begin(), packets.end(), random);
    PacketParts parts;
    for (size_t i = 0; i + 1 < packets.size(); ++i) EXPECT_FALSE(Add(parts, packets[i]));
    const auto whole = Add(parts, packets.back());
    ASSERT_TRUE(whole) << size;
    EXPECT_EQ(whole->channel, kChannel);
    EXPECT_EQ(whole->bytes, message);
    EXPECT_EQ(parts.n_open(), 0U);
  }
}

TEST(PacketParts, AttemptsCompleteOneMessage) {
  const auto message = RandomMessage(60'000);
  const std::vector<Packet> first = PartsOf(message, 3, 0), second = PartsOf(message, 3, 1);
  PacketParts parts;
  for (size_t i = 0; i < first.size(); i += 2) EXPECT_FALSE(Add(parts, first[i]));
  std::optional<LongMessages::Message> whole;
  for (size_t i = 0; i < second.size() && !whole; ++i) whole = Add(parts, second[i]);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->bytes, message);
}

TEST(PacketParts, OtherMessagesAreKeptApart) {
  const auto a = RandomMessage(3000, 1), b = RandomMessage(3000, 2);
  PacketParts parts;
  // Another number, another socket, and the same number again once the first message is out of date.
  EXPECT_FALSE(Add(parts, PartsOf(a, 1, 0)[0]));
  for (const Packet& packet : {PartsOf(b, 2, 0)[1], PartsOf(b, 2, 0)[2]}) EXPECT_FALSE(Add(parts, packet));
  for (const Packet& packet : {PartsOf(b, 1, 0)[1], PartsOf(b, 1, 0)[2]}) EXPECT_FALSE(Add(parts, packet, 0, 2));
  EXPECT_EQ(parts.n_open(), 3U);
  const int64_t later = PacketParts::kPatience_ns + 1;
  EXPECT_FALSE(Add(parts, PartsOf(b, 1, 0)[1], later));
  EXPECT_FALSE(Add(parts, PartsOf(b, 1, 0)[2], later));
  EXPECT_EQ(parts.n_open(), 1U);
  const auto whole = Add(parts, PartsOf(b, 1, 0)[0], later);
  ASSERT_TRUE(whole);
  EXPECT_EQ(whole->bytes, b);
  // Another size is another message.
  EXPECT_FALSE(Add(parts, PartsOf(a, 1, 0)[0]));
  EXPECT_FALSE(Add(parts, PartsOf(RandomMessage(2500), 1, 0)[1]));
  EXPECT_EQ(parts.n_open(), 1U);
}

TEST(PacketParts, IncompleteMessagesAreBounded) {
  PacketParts parts;
  const auto message = RandomMessage(60'000);
  for (int64_t seq = 0; seq < 1000; ++seq) EXPECT_FALSE(Add(parts, PartsOf(message, seq, 0)[0]));
  EXPECT_LE(parts.n_open(), PacketParts::kMostOpen);
  Packet huge = PartsOf(message, 1, 0)[1];
  huge[8] = 0x7f;  // the length of the message
  PacketParts none;
  EXPECT_FALSE(Add(none, huge));
  EXPECT_EQ(none.n_open(), 0U);
}

TEST(PacketParts, NumbersNameTheChannel) {
  EXPECT_EQ(DigestOf(PartsNumber(kChannel, 1 << 20, 77)), ChannelDigest(kChannel));
  EXPECT_NE(ChannelDigest("KEYFRAME"), ChannelDigest("MAP_UPDATE"));
  EXPECT_FALSE(DigestOf(12345)) << "LCM numbers its messages from 0 on";
}

// LCM's own receiver reads such messages, and ours reads them by the bus's transport.
TEST(PacketParts, StockLcmReadsThem) {
  const std::string url = test::PrivateUrl();
  lcm_t* const lcm = lcm_create(url.c_str());
  ASSERT_NE(lcm, nullptr);
  std::vector<uint8_t> by_lcm, by_us;
  lcm_subscribe(
      lcm, kChannel,
      [](const lcm_recv_buf_t* buffer, const char*, void* user) {
        const auto* bytes = static_cast<const uint8_t*>(buffer->data);
        static_cast<std::vector<uint8_t>*>(user)->assign(bytes, bytes + buffer->data_size);
      },
      &by_lcm);
  Transport receiver(url), sender(url);
  receiver.SetReceiver([&](std::string_view, ByteView bytes) { by_us.assign(bytes.begin(), bytes.end()); });
  receiver.Listen(kChannel);
  const auto message = RandomMessage(50'000);
  ASSERT_TRUE(sender.SendInPackets(kChannel, message, 4));
  EXPECT_GT(lcm_handle_timeout(lcm, 10'000), 0);
  for (int i = 0; i < 100 && by_us.empty(); ++i) receiver.Receive(100);
  EXPECT_EQ(by_lcm, message);
  EXPECT_EQ(by_us, message);
  lcm_destroy(lcm);
}

}  // namespace
}  // namespace plslam::bus
