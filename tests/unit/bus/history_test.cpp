// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/history.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "tests/unit/bus/bus_fixture.h"
#include "tests/unit/bus/numbered_messages.h"

namespace plslam::bus {
namespace {

using test::MessageOf;
using test::NumberOf;
TEST(History, SpillsToALogAndReadsItBack) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "deep/CHANNEL.lcmlog";
  {
    History history(Retention::kAll, 10'000, "CHANNEL", path, false);
    for (int64_t n = 0; n < 1000; ++n) history.Append(MessageOf(n, 100 + static_cast<size_t>(n % 50)));
    EXPECT_LE(history.memory_bytes(), 10'000);
    EXPECT_GT(history.spilled(), 900);
    EXPECT_EQ(history.first_seq(), 0);
    EXPECT_EQ(history.next_seq(), 1000);
    for (const int64_t n : {0, 1, 500, 7, 950, 999}) {
      const Bytes message = history.Get(n);
      ASSERT_NE(message, nullptr) << n;
      EXPECT_EQ(*message, *MessageOf(n, 100 + static_cast<size_t>(n % 50)));
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "deep")) << "a process that is killed can remove nothing";
    history.Append(MessageOf(1000));
    EXPECT_EQ(NumberOf(history.Get(920)), 920);
    EXPECT_EQ(history.Get(1001), nullptr);
    EXPECT_EQ(history.Get(-1), nullptr);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(History, KeepsItsLogWhereItIsToldTo) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "CHANNEL.lcmlog";
  {
    History history(Retention::kAll, 1000, "CHANNEL", path, true);
    for (int64_t n = 0; n < 100; ++n) history.Append(MessageOf(n));
  }
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(History, BeginsLaterWhereTheDiskDoesNotTakeIt) {
  History history(Retention::kAll, 1000, "CHANNEL", "/proc/nowhere/CHANNEL.lcmlog", false);
  for (int64_t n = 0; n < 100; ++n) history.Append(MessageOf(n));
  EXPECT_EQ(history.first_seq(), 90);
  EXPECT_EQ(history.Get(5), nullptr);
  EXPECT_EQ(NumberOf(history.Get(95)), 95);
}

TEST(History, OfUnacknowledgedMessagesStaysInMemoryAndBounded) {
  History history(Retention::kUnacknowledged, 1000, "CHANNEL", "", false);
  for (int64_t n = 0; n < 100; ++n) history.Append(MessageOf(n));
  EXPECT_EQ(history.first_seq(), 90);
  history.Forget(95);
  EXPECT_EQ(history.first_seq(), 95);
  EXPECT_EQ(history.Get(94), nullptr);
}

}  // namespace
}  // namespace plslam::bus
