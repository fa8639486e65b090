// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/ordered_reader.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/bus/numbered_messages.h"

namespace plslam::bus {
namespace {

using test::Drain;
using test::kMs;
using test::MessageOf;

using Numbers = std::vector<int64_t>;

TEST(OrderedReader, DeliversReorderedMessagesInOrder) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 2, 3, 1}) reader.OnMessage(n, *MessageOf(n), 0);
  EXPECT_EQ(Drain(reader, 0), (Numbers{0, 1, 2, 3}));
  EXPECT_EQ(reader.lost(), 0) << "it was overtaken, and was not requested";
  EXPECT_EQ(reader.repaired(), 0);
}

TEST(OrderedReader, CountsRequestedMessagesAsLost) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 2, 5}) reader.OnMessage(n, *MessageOf(n), 0);
  for (int64_t now = 0; now < 100 * kMs; now += kMs) reader.Poll(now);
  EXPECT_EQ(reader.lost(), 3);
  for (const int64_t n : {1, 3}) reader.OnMessage(n, *MessageOf(n), 0);
  EXPECT_EQ(reader.lost(), 3);
  EXPECT_EQ(reader.repaired(), 2);
}

TEST(OrderedReader, ForgedNumbersAreNoLoss) {
  static constexpr int64_t kFar = 45'000'000;
  for (const bool announced : {false, true}) {
    OrderedReader reader(true, 1'000'000, 0);
    reader.OnMessage(0, *MessageOf(0), 0);
    Drain(reader, 0);
    if (announced) reader.OnAnnounce(0, kFar, 0);
    if (!announced) reader.OnMessage(kFar, *MessageOf(kFar), 0);
    // The publisher continues as before.
    for (int64_t n = 1; n < 2000; ++n) {
      reader.OnMessage(n, *MessageOf(n), n * 10 * kMs);
      reader.Poll(n * 10 * kMs);
      Drain(reader, n * 10 * kMs);
    }
    EXPECT_LE(reader.lost(), 2064) << "announced: " << announced;
    reader.OnAnnounce(kFar, kFar + 1, 20'000 * kMs);
    reader.Poll(20'000 * kMs);
    EXPECT_LE(reader.lost() - reader.repaired(), 128) << "announced: " << announced;
  }
}

TEST(OrderedReader, ForgedHistoryIsNoLoss) {
  OrderedReader reader(true, 1'000'000, 0);
  reader.OnAnnounce(0, 45'000'000, 0, 0);
  for (int64_t now = 0; now < 90'000 * kMs; now += 10 * kMs) reader.Poll(now);
  EXPECT_GT(reader.delivered(), 40'000'000) << "it has been given up";
  EXPECT_LE(reader.lost(), 64);
}

TEST(OrderedReader, RequestsAGapAtOnceAndNothingElse) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 1, 5, 6, 8}) reader.OnMessage(n, *MessageOf(n), 0);
  Drain(reader, 0);
  ASSERT_LE(reader.poll_time(), 0);
  const auto request = reader.Poll(0);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->delivered, 1);
  ASSERT_EQ(request->ranges.size(), 2U);
  EXPECT_EQ(request->ranges[0].first, 2);
  EXPECT_EQ(request->ranges[0].last, 4);
  EXPECT_EQ(request->ranges[1].first, 7);
  EXPECT_EQ(request->ranges[1].last, 7);
}

TEST(OrderedReader, RepeatsRequestsWithGrowingPauses) {
  OrderedReader reader(true, 1'000'000, 0);
  reader.OnMessage(0, *MessageOf(0), 0);
  reader.OnMessage(2, *MessageOf(2), 0);
  std::vector<int64_t> times;
  for (int64_t now = 0; now < 1000 * kMs; now += kMs) {
    if (const auto request = reader.Poll(now); request && !request->ranges.empty()) times.push_back(now / kMs);
  }
  EXPECT_EQ(times, (Numbers{0, 3, 9, 21, 45, 93, 189, 381, 581, 781, 981}));
}

TEST(OrderedReader, CountsRepetitions) {
  OrderedReader reader(true, 1'000'000, 0);
  using Arrival = OrderedReader::Arrival;
  EXPECT_EQ(reader.OnMessage(0, *MessageOf(0), 0), Arrival::kNew);
  EXPECT_EQ(reader.OnMessage(0, *MessageOf(0), 0), Arrival::kDuplicate);
  Drain(reader, 0);
  EXPECT_EQ(reader.OnMessage(0, *MessageOf(0), 0), Arrival::kDuplicate);
  EXPECT_TRUE(Drain(reader, 0).empty());
}

TEST(OrderedReader, FindsALostTailByTheAnnouncement) {
  OrderedReader reader(true, 1'000'000, 0);
  reader.OnMessage(0, *MessageOf(0), 0);
  Drain(reader, 0);
  reader.Poll(0);
  reader.OnAnnounce(0, 3, 3 * kMs);
  const auto request = reader.Poll(3 * kMs);
  ASSERT_TRUE(request);
  ASSERT_EQ(request->ranges.size(), 1U);
  EXPECT_EQ(request->ranges[0].first, 1);
  EXPECT_EQ(request->ranges[0].last, 2);
}

TEST(OrderedReader, LateJoinerBeginsAtTheOldestKeptMessage) {
  OrderedReader reader(true, 1'000'000, 0);
  reader.OnMessage(50, *MessageOf(50), 0);
  EXPECT_TRUE(Drain(reader, 0).empty());
  const auto question = reader.Poll(0);
  ASSERT_TRUE(question);
  EXPECT_EQ(question->delivered, -1);
  EXPECT_TRUE(question->ranges.empty());
  reader.OnAnnounce(48, 51, kMs);
  const auto request = reader.Poll(kMs);
  ASSERT_TRUE(request);
  ASSERT_EQ(request->ranges.size(), 1U);
  EXPECT_EQ(request->ranges[0].first, 48);
  EXPECT_EQ(request->ranges[0].last, 49);
  reader.OnMessage(48, *MessageOf(48), 2 * kMs);
  reader.OnMessage(49, *MessageOf(49), 2 * kMs);
  EXPECT_EQ(Drain(reader, 2 * kMs), (Numbers{48, 49, 50}));
  EXPECT_EQ(reader.lost(), 0) << "what was sent before we listened was not lost on the wire";
}

TEST(OrderedReader, LateJoinerGetsMessagesDroppedSince) {
  OrderedReader reader(true, 1'000'000, 0);
  reader.OnMessage(20, *MessageOf(20), 0);
  reader.OnMessage(22, *MessageOf(22), 0);
  EXPECT_EQ(Drain(reader, 0), Numbers());
  reader.OnAnnounce(23, 25, 0);
  EXPECT_EQ(Drain(reader, 0), (Numbers{20}));
  reader.OnMessage(23, *MessageOf(23), 0);
  reader.OnMessage(24, *MessageOf(24), 0);
  reader.OnAnnounce(23, 25, 0);
  EXPECT_EQ(Drain(reader, 0), (Numbers{22, 23, 24}));
}

TEST(OrderedReader, GivesUpGapsOfASilentPublisher) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 3, 5}) reader.OnMessage(n, *MessageOf(n), 0);
  Numbers numbers = Drain(reader, 0);
  for (int64_t now = 0; now < 60'000 * kMs; now += 10 * kMs) {
    reader.Poll(now);
    const Numbers more = Drain(reader, now);
    if (!more.empty()) {
      EXPECT_GE(now, 30'000 * kMs);
    }
    numbers.insert(numbers.end(), more.begin(), more.end());
  }
  EXPECT_EQ(numbers, (Numbers{0, 3, 5}));
  EXPECT_EQ(reader.lost(), 3);
  EXPECT_EQ(reader.repaired(), 0);
}

TEST(OrderedReader, IsPolledSeldomWhileThePublisherIsSilent) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 3}) reader.OnMessage(n, *MessageOf(n), 0);
  Drain(reader, 0);
  int polls = 0;
  int64_t given_up = -1;
  for (int64_t now = 0; now < 60'000 * kMs && given_up < 0; now = std::max(now + 1, reader.poll_time())) {
    reader.Poll(now);
    ++polls;
    if (!Drain(reader, now).empty()) given_up = now;
  }
  EXPECT_NEAR(static_cast<double>(given_up) / kMs, 30'000.0, 1.0);
  // It requests again every 200 ms, and each time it may acknowledge.
  EXPECT_LT(polls, 2 * 30'000 / 200 + 20);
}

TEST(OrderedReader, OneWayPollsOnlyToGiveUpAGap) {
  OrderedReader reader(false, 1'000'000, 0);
  Numbers numbers;
  for (int64_t n = 0; n < 300; ++n) {
    if (n == 20) continue;
    reader.OnMessage(n, *MessageOf(n), n * kMs);
    for (const int64_t m : Drain(reader, n * kMs)) numbers.push_back(m);
    const bool is_due = reader.poll_time() <= n * kMs;
    EXPECT_EQ(is_due, n == 20 + 257) << n;
    if (!is_due) continue;
    EXPECT_FALSE(reader.Poll(n * kMs));
    for (const int64_t m : Drain(reader, n * kMs)) numbers.push_back(m);
  }
  EXPECT_EQ(numbers.size(), 299U);
  EXPECT_EQ(reader.poll_time(), INT64_MAX) << "there is no publisher to acknowledge to";
}

TEST(OrderedReader, SurvivesALinkOutage) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 2}) reader.OnMessage(n, *MessageOf(n), 0);
  Numbers numbers = Drain(reader, 0);
  // No message arrives for 25 s; then announcements, and the missing message another 5 s later.
  for (int64_t now = 0; now < 30'000 * kMs; now += 50 * kMs) {
    if (now >= 25'000 * kMs) reader.OnAnnounce(0, 3, now);
    reader.Poll(now);
    for (const int64_t n : Drain(reader, now)) numbers.push_back(n);
  }
  EXPECT_EQ(numbers, (Numbers{0}));
  reader.OnMessage(1, *MessageOf(1), 30'000 * kMs);
  for (const int64_t n : Drain(reader, 30'000 * kMs)) numbers.push_back(n);
  EXPECT_EQ(numbers, (Numbers{0, 1, 2}));
}

TEST(OrderedReader, GivesUpGapsThatAreNotResent) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 2}) reader.OnMessage(n, *MessageOf(n), 0);
  Numbers numbers = Drain(reader, 0);
  for (int64_t now = 0; now < 12'000 * kMs; now += 50 * kMs) {
    reader.OnMessage(0, *MessageOf(0), now);
    reader.Poll(now);
    for (const int64_t n : Drain(reader, now)) numbers.push_back(n);
    EXPECT_EQ(numbers.size(), now > 10'000 * kMs ? 2U : 1U) << now / kMs << " ms";
  }
}

TEST(OrderedReader, WaitsLongerForAnnouncedMessages) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 2}) reader.OnMessage(n, *MessageOf(n), 0);
  Numbers numbers = Drain(reader, 0);
  for (int64_t now = 0; now < 62'000 * kMs; now += 50 * kMs) {
    reader.OnAnnounce(0, 3, now);
    reader.Poll(now);
    for (const int64_t n : Drain(reader, now)) numbers.push_back(n);
    EXPECT_EQ(numbers.size(), now > 60'000 * kMs ? 2U : 1U) << now / kMs << " ms";
  }
}

TEST(OrderedReader, IsPolledSeldomWhileWaitingForAnnounced) {
  OrderedReader reader(true, 1'000'000, 0);
  for (const int64_t n : {0, 2}) reader.OnMessage(n, *MessageOf(n), 0);
  Drain(reader, 0);
  int polls = 0;
  int64_t given_up = -1;
  int64_t announced = 0;
  for (int64_t now = 0; now < 90'000 * kMs && given_up < 0; now = std::max(now + 1, reader.poll_time())) {
    if (now - announced > 1'000 * kMs) reader.OnAnnounce(0, 3, announced = now);
    reader.Poll(now);
    ++polls;
    if (!Drain(reader, now).empty()) given_up = now;
  }
  EXPECT_NEAR(static_cast<double>(given_up) / kMs, 60'000.0, 250.0);
  EXPECT_LT(polls, 2 * 60'000 / 200 + 200);
}

TEST(OrderedReader, OneWayEndGivesUpAllGaps) {
  OrderedReader reader(false, 1'000'000, 0);
  for (const int64_t n : {0, 1, 3, 4, 7}) reader.OnMessage(n, *MessageOf(n), 0);
  EXPECT_EQ(Drain(reader, 0), (Numbers{0, 1}));
  EXPECT_GT(reader.poll_time(), 0);
  reader.OnEnd();
  Numbers numbers;
  while (reader.poll_time() <= 0) {
    EXPECT_FALSE(reader.Poll(0));
    for (const int64_t n : Drain(reader, 0)) numbers.push_back(n);
  }
  EXPECT_EQ(numbers, (Numbers{3, 4, 7}));
}

TEST(OrderedReader, NewReaderBeginsAtTheAnnouncedMessage) {
  OrderedReader newcomer(true, 1'000'000, 0), owed(true, 1'000'000, 0);
  newcomer.OnAnnounce(10, 25, 0, 24);
  EXPECT_EQ(newcomer.delivered(), 23);
  owed.OnMessage(0, *MessageOf(0), 0);
  Drain(owed, 0);
  owed.OnAnnounce(1, 25, 0, 24);
  EXPECT_EQ(owed.delivered(), 0);
  OrderedReader lied_to(true, 1'000'000, 0);
  lied_to.OnAnnounce(10, 25, 0, -7);
  EXPECT_EQ(lied_to.delivered(), 9);
}

TEST(OrderedReader, IgnoresInvalidAnnouncements) {
  OrderedReader reader(true, 1'000'000, 0);
  reader.OnMessage(0, *MessageOf(0), 0);
  Drain(reader, 0);
  reader.OnAnnounce(-5, 3, 0);
  reader.OnAnnounce(7, 3, 0);
  reader.OnAnnounce(0, int64_t{1} << 60, 0);
  EXPECT_EQ(reader.lost(), 0);
  EXPECT_EQ(reader.OnMessage(int64_t{1} << 60, *MessageOf(9), 0), OrderedReader::Arrival::kRefused);
}

TEST(OrderedReader, RefusesSequenceNumbersNearTheMaximum) {
  for (const bool two_way : {true, false}) {
    for (const int64_t n : {INT64_MAX, INT64_MAX - 1, INT64_MAX - 50'000'000, kMaxNumber + 1}) {
      OrderedReader reader(two_way, 1'000'000, 0);
      EXPECT_EQ(reader.OnMessage(n, *MessageOf(9), 0), OrderedReader::Arrival::kRefused) << n;
      reader.OnAnnounce(n - 1, n, 0);
      reader.OnAnnounce(n, n, 0, n);
      EXPECT_EQ(reader.delivered(), -1) << n;
      EXPECT_EQ(reader.OnMessage(0, *MessageOf(0), 0), OrderedReader::Arrival::kNew);
      EXPECT_EQ(Drain(reader, 0), (Numbers{0}));
    }
  }
}

TEST(OrderedReader, OutOfOrderMessagesAreBounded) {
  OrderedReader reader(true, 10'000, 0);
  reader.OnMessage(0, *MessageOf(0), 0);
  Drain(reader, 0);
  for (int64_t n = 2; n < 1000; ++n) reader.OnMessage(n, *MessageOf(n), 0);
  EXPECT_LE(reader.buffered_bytes(), 10'000);
  EXPECT_EQ(reader.OnMessage(1, *MessageOf(1), 0), OrderedReader::Arrival::kNew);
  EXPECT_EQ(Drain(reader, 0).size(), 101U);
}

}  // namespace
}  // namespace plslam::bus
