// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/long_messages.h"

#include <gtest/gtest.h>
#include <lcm/lcm.h>

#include <chrono>
#include <numeric>
#include <random>
#include <thread>

#include "core/bus/transport/stock_lcm.h"
#include "tests/unit/bus/bus_fixture.h"

namespace plslam::bus {
namespace {

using Packet = std::vector<uint8_t>;

Packet PartOf(uint32_t number, uint32_t size, uint32_t offset, uint16_t part, uint16_t parts,
              const std::string& rest) {
  Packet packet = {'L', 'C', '0', '3'};
  const auto append = [&packet](uint32_t value, int n) {
    for (int i = n - 1; i >= 0; --i) packet.push_back(static_cast<uint8_t>(value >> (8 * i)));
  };
  append(number, 4);
  append(size, 4);
  append(offset, 4);
  append(part, 2);
  append(parts, 2);
  packet.insert(packet.end(), rest.begin(), rest.end());
  return packet;
}

/// Returns "CHANNEL:bytes" of the message that this packet completes.
std::string Add(LongMessages& messages, uint64_t sender, const Packet& packet) {
  const auto part = ParsePart(packet);
  if (!part) return "junk";
  const auto message = messages.Add(sender, *part);
  return message ? message->channel + ":" + std::string(message->bytes.begin(), message->bytes.end()) : "";
}

LongMessages AllButX() {
  return LongMessages([](std::string_view channel) { return channel != "X"; });
}

TEST(LongMessages, PartsInOrderOfSeveralSenders) {
  using std::string_literals::operator""s;
  LongMessages messages = AllButX();
  EXPECT_EQ(Add(messages, 1, PartOf(7, 6, 0, 0, 3, "A\0ab"s)), "");
  EXPECT_EQ(Add(messages, 2, PartOf(7, 4, 0, 0, 2, "B\0xy"s)), "");
  EXPECT_EQ(Add(messages, 1, PartOf(7, 6, 2, 1, 3, "cd")), "");
  EXPECT_EQ(Add(messages, 2, PartOf(7, 4, 2, 1, 2, "zw")), "B:xyzw");
  EXPECT_EQ(Add(messages, 1, PartOf(7, 6, 4, 2, 3, "ef")), "A:abcdef");
  EXPECT_EQ(Add(messages, 1, PartOf(8, 2, 0, 0, 2, "X\0a"s)), "") << "not wanted";
  EXPECT_EQ(messages.lost(), 0);
  EXPECT_EQ(messages.bytes(), 0U);
}

TEST(LongMessages, LostPartLosesItsMessageAlone) {
  using std::string_literals::operator""s;
  LongMessages messages = AllButX();
  Add(messages, 1, PartOf(7, 6, 0, 0, 3, "A\0ab"s));
  EXPECT_EQ(Add(messages, 1, PartOf(7, 6, 4, 2, 3, "ef")), "");
  EXPECT_EQ(messages.lost(), 1);
  Add(messages, 1, PartOf(8, 4, 0, 0, 2, "A\0ab"s));
  Add(messages, 1, PartOf(9, 4, 0, 0, 2, "A\0gh"s));
  EXPECT_EQ(messages.lost(), 2) << "the end of 8 did not come";
  EXPECT_EQ(Add(messages, 1, PartOf(9, 4, 2, 1, 2, "ij")), "A:ghij");
}

TEST(LongMessages, ForgedPartsTakeNoMemory) {
  using std::string_literals::operator""s;
  LongMessages messages = AllButX();
  EXPECT_EQ(Add(messages, 1, PartOf(1, 4, 0, 0, 2, "no end of the name")), "junk");
  EXPECT_EQ(Add(messages, 1, PartOf(1, 4, 2, 2, 2, "ab")), "junk") << "beyond the last part";
  EXPECT_EQ(Add(messages, 1, PartOf(1, 4, 3, 1, 2, "ab")), "junk") << "beyond the end";
  EXPECT_EQ(Add(messages, 1, PartOf(1, 4, 0xffffffff, 1, 2, "ab")), "junk");
  for (uint32_t i = 0; i < 100'000; ++i) Add(messages, i, PartOf(1, 99'000'000, 0, 0, 2000, "A\0ab"s));
  EXPECT_LE(messages.bytes(), 200U);
  std::mt19937_64 engine(1);
  const auto random = [&engine] { return static_cast<uint8_t>(engine()); };
  for (int i = 0; i < 200'000; ++i) {
    Packet packet = PartOf(0, random() % 8, random() % 4, static_cast<uint16_t>(random() % 3),
                           static_cast<uint16_t>(random() % 4), "A\0abc"s);
    packet.resize(packet.size() - random() % 6);
    Add(messages, random() % 3, packet);
  }
  EXPECT_LE(messages.bytes(), 1000U);
}

/// From LCM's own sender, on a private port.
TEST(StockLcm, TakesLongAndShortMessagesOfLcm) {
  const std::string url = test::PrivateUrl();
  StockLcm reader(url, "test");
  std::vector<size_t> sizes;
  bool equal = true;
  std::vector<uint8_t> sent(1'000'000);
  std::iota(sent.begin(), sent.end(), uint8_t{0});
  reader.Subscribe("/image#of.a.Robot", [&](ByteView bytes) {
    sizes.push_back(bytes.size());
    equal = equal && std::equal(bytes.begin(), bytes.end(), sent.begin());
  });
  lcm_t* const lcm = lcm_create(url.c_str());
  ASSERT_NE(lcm, nullptr);
  const std::vector<size_t> expected = {10, 60'000, 65'499, 65'500, 100'000, 131'000, 131'100};
  for (const size_t size : expected) {
    lcm_publish(lcm, "/image#of.another", sent.data(), static_cast<unsigned>(size));
    lcm_publish(lcm, "/image#of.a.Robot", sent.data(), static_cast<unsigned>(size));
    for (int i = 0; i < 5; ++i) reader.Handle(10);
  }
  lcm_destroy(lcm);
  EXPECT_EQ(sizes, expected);
  EXPECT_TRUE(equal);
  EXPECT_EQ(reader.lost(), 0);
}

TEST(StockLcm, NamesTheOptionOfABadUrl) {
  try {
    StockLcm("udpm://10.0.0.1:7667", "adapter.foreign_url").Subscribe("A", [](ByteView) {});
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_EQ(std::string(error.what()).find("adapter.foreign_url: udpm://10.0.0.1:7667"), 0U) << error.what();
  }
}

}  // namespace
}  // namespace plslam::bus
