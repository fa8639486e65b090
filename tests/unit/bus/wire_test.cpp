// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/transport/wire.h"

#include <algorithm>
#include <fstream>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/bus/channels.h"
#include "tests/support/data_folder.h"
#include "tests/unit/bus/allocation_counter.h"
#include "tests/unit/bus/random_message.h"

namespace plslam::bus {
namespace {

using test::allocated;
using test::DecodeAndEncode;
using test::RandomMessage;

class EveryType : public testing::TestWithParam<std::string> {
 protected:
  const MessageLayout& layout() const { return *FindMessageLayout(GetParam()); }
  std::mt19937_64 random_{std::hash<std::string>()(GetParam())};
};

TEST(Layouts, CoverTheGeneratedTypes) {
  std::vector<std::string> names;
  for (const MessageLayout& layout : MessageLayouts()) names.emplace_back(layout.name);
  EXPECT_EQ(names, test::GeneratedTypes());
}

TEST_P(EveryType, RoundTripThroughTheGeneratedClass) {
  for (int i = 0; i < 200; ++i) {
    const auto bytes = RandomMessage(layout(), random_);
    ASSERT_EQ(MessageLength(layout(), bytes), bytes.size());
    const auto again = DecodeAndEncode(GetParam(), bytes);
    ASSERT_TRUE(again.decoded);
    ASSERT_EQ(again.encoded, bytes);
  }
}

TEST_P(EveryType, RefusesEveryTruncation) {
  for (int i = 0; i < 20; ++i) {
    const auto bytes = RandomMessage(layout(), random_);
    for (size_t n = 0; n < bytes.size(); ++n) {
      ASSERT_FALSE(MessageLength(layout(), ByteView(bytes).first(n))) << n << " of " << bytes.size();
    }
  }
}

TEST_P(EveryType, ToleratesTrailingBytes) {
  auto bytes = RandomMessage(layout(), random_);
  const size_t length = bytes.size();
  bytes.resize(length + 32, 0xAB);
  EXPECT_EQ(MessageLength(layout(), bytes), length);
}

TEST_P(EveryType, RefusesAnotherFingerprint) {
  auto bytes = RandomMessage(layout(), random_);
  for (size_t bit = 0; bit < 64; ++bit) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    EXPECT_FALSE(MessageLength(layout(), bytes));
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
  }
}

/// The generated decoder accepts every message that passes the check, in memory bounded by the size of the message.
TEST_P(EveryType, MutatedBytesAreHarmless) {
  static constexpr size_t kPerByte = 64;
  size_t accepted = 0;
  for (int i = 0; i < 2000; ++i) {
    auto bytes = RandomMessage(layout(), random_);
    for (uint64_t n = 1 + random_() % 4; n > 0 && bytes.size() > 8; --n) {
      const size_t at = 8 + random_() % (bytes.size() - 8);
      bytes[at] = random_() % 3 == 0 ? 0xFF : static_cast<uint8_t>(random_());
    }
    if (random_() % 4 == 0) bytes.resize(bytes.size() + random_() % 64, static_cast<uint8_t>(random_()));
    const auto length = MessageLength(layout(), bytes);
    if (!length) continue;
    ++accepted;
    ASSERT_LE(*length, bytes.size());
    allocated = 0;
    const auto again = DecodeAndEncode(GetParam(), ByteView(bytes).first(*length));
    const size_t used = allocated;
    ASSERT_TRUE(again.decoded);
    ASSERT_LE(used, kPerByte * bytes.size() + 1000);
  }
  RecordProperty("accepted", static_cast<int>(accepted));
}

/// Each array length of the message replaced by the worst a sender can think of.
TEST_P(EveryType, RefusesHostileLengths) {
  for (int i = 0; i < 50; ++i) {
    const auto bytes = RandomMessage(layout(), random_);
    for (const uint32_t lie : {0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU, 0x10000000U, 0x00100000U}) {
      for (size_t at = 8; at + 4 <= bytes.size(); ++at) {
        auto hostile = bytes;
        for (size_t k = 0; k < 4; ++k) hostile[at + k] = static_cast<uint8_t>(lie >> (24 - 8 * k));
        const auto length = MessageLength(layout(), hostile);
        if (!length) continue;
        allocated = 0;
        ASSERT_TRUE(DecodeAndEncode(GetParam(), ByteView(hostile).first(*length)).decoded);
        ASSERT_LE(allocated, 64 * bytes.size() + 1000) << "at " << at;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Types, EveryType, testing::ValuesIn(test::GeneratedTypes()),
                         [](const auto& test) { return test.param; });

/// The rows of the table in a Markdown file, without blanks.
std::vector<std::string> Rows(const std::string& path) {
  std::ifstream in(path);
  std::vector<std::string> rows;
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("| ") && line.find("| channel |") == std::string::npos) rows.push_back(line);
  }
  return rows;
}

TEST(ChannelTable, IsInTheReadme) {
  std::vector<std::string> expected;
  for (const Channel& c : Channels()) {
    const std::string kept = c.retention == Retention::kAll              ? "all"
                             : c.retention == Retention::kUnacknowledged ? "unacknowledged"
                                                                         : "-";
    const std::string delivery = c.delivery == Delivery::kEvery ? "every" : "latest";
    std::string row;
    for (const auto& cell : {std::string(c.name), std::string(c.type), std::string(c.publisher), delivery, kept,
                             std::string(c.meaning)}) {
      row += "| " + cell + " ";
    }
    expected.push_back(row + "|");
  }
  EXPECT_EQ(Rows((plslam::test::SourceFolder() / "lcmtypes/README.md").string()), expected);
}

TEST(ChannelTable, NamesTypesThatBeginWithAHeader) {
  for (const Channel& channel : Channels()) {
    const MessageLayout* layout = FindMessageLayout(channel.type);
    ASSERT_NE(layout, nullptr) << channel.type;
    EXPECT_EQ(layout->members[0].name, "header") << channel.type;
    EXPECT_TRUE(std::regex_match(std::string(channel.name), std::regex("[A-Z]+(_[A-Z]+)*"))) << channel.name;
    EXPECT_EQ(channel.delivery == Delivery::kLatest, channel.retention == Retention::kNone) << channel.name;
  }
}

TEST(ReadHeader, AgreesWithTheGeneratedClass) {
  std::mt19937_64 random(1);
  const auto bytes = RandomMessage(*FindMessageLayout("announce_t"), random);
  const WireHeader header = ReadHeader(bytes);
  EXPECT_EQ(header.schema, ReadInt32(&bytes[8]));
  EXPECT_EQ(header.source.value, ReadInt64(&bytes[12]));
  EXPECT_EQ(header.t_ns, ReadInt64(&bytes[36]));
  EXPECT_EQ(kWireHeaderBytes, 44U);
}

}  // namespace
}  // namespace plslam::bus
