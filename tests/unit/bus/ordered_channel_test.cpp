// SPDX-License-Identifier: BSD-3-Clause
#include <deque>
#include <random>

#include <gtest/gtest.h>

#include "core/bus/delivery/ordered_reader.h"
#include "core/bus/delivery/ordered_writer.h"
#include "tests/unit/bus/numbered_messages.h"

namespace plslam::bus {
namespace {

using test::Drain;
using test::kMs;
using test::MessageOf;
using test::NumberOf;

OrderedWriter WriterOf(Retention retention = Retention::kAll) { return OrderedWriter(retention, 100'000'000); }

using Numbers = std::vector<int64_t>;

TEST(OrderedWriter, LimitsUnacknowledgedBytesToReaderWindow) {
  OrderedWriter writer = WriterOf();
  const int64_t window = 133'120;  // of the default receive buffer
  writer.OnHello(7, window, 0);
  int sent = 0;
  while (writer.WindowOpen(60'000, 0) && sent < 100) writer.Sent(MessageOf(sent++, 60'000), 0);
  EXPECT_EQ(sent, 2);
  writer.OnRequest(7, 0, window, {}, 0);
  EXPECT_TRUE(writer.WindowOpen(60'000, 0));
}

TEST(OrderedWriter, DoesNotWaitForASilentReader) {
  OrderedWriter writer = WriterOf();
  writer.OnHello(7, 64'000, 0);
  writer.Sent(MessageOf(0, 60'000), 0);
  EXPECT_FALSE(writer.WindowOpen(60'000, 1000 * kMs));
  EXPECT_TRUE(writer.WindowOpen(60'000, 1501 * kMs));
}

TEST(OrderedWriter, DoesNotWaitForALaggingReader) {
  OrderedWriter writer = WriterOf();
  writer.OnHello(7, 64'000, 0);
  writer.Sent(MessageOf(0, 60'000), 0);
  EXPECT_FALSE(writer.WindowOpen(60'000, 0));
  writer.SuspendSlowReaders(60'000, 0);
  for (int64_t n = 1; n < 5; ++n) {
    EXPECT_TRUE(writer.WindowOpen(60'000, 0));
    writer.Sent(MessageOf(n, 60'000), 0);
  }
  writer.OnRequest(7, 4, 64'000, {}, 0);
  writer.Sent(MessageOf(5, 60'000), 0);
  EXPECT_FALSE(writer.WindowOpen(60'000, 0));
}

TEST(OrderedWriter, IgnoresAcknowledgementsOfUnsentMessages) {
  OrderedWriter writer = WriterOf(Retention::kUnacknowledged);
  writer.OnHello(7, 64'000, 0);
  writer.Sent(MessageOf(0), 0);
  writer.OnRequest(7, INT64_MAX, 64'000, {{-5, INT64_MAX}}, 0);
  EXPECT_FALSE(writer.AllDelivered(0));
  EXPECT_EQ(writer.history().first_seq(), 0);
}

TEST(OrderedWriter, AnswersARequestWithAtMostAWindow) {
  OrderedWriter writer = WriterOf();
  for (int64_t n = 0; n < 100; ++n) writer.Sent(MessageOf(n, 30'000), 0);
  const auto answer = writer.OnRequest(7, -1, 133'120, {{0, 99}}, 0);
  EXPECT_TRUE(answer.announce);
  ASSERT_EQ(answer.resend.size(), 3U);
  EXPECT_EQ(NumberOf(answer.resend[2].message), 2);
}

TEST(OrderedWriter, DropsFullyAcknowledgedMessages) {
  OrderedWriter writer = WriterOf(Retention::kUnacknowledged);
  writer.OnHello(7, 500'000, 0);
  writer.OnHello(8, 500'000, 0);
  for (int64_t n = 0; n < 10; ++n) writer.Sent(MessageOf(n), 0);
  writer.OnRequest(7, 9, 500'000, {}, 4'000 * kMs);
  EXPECT_EQ(writer.history().first_seq(), 0);
  writer.OnRequest(8, 5, 500'000, {}, 4'000 * kMs);
  EXPECT_EQ(writer.history().first_seq(), 6);
  writer.OnRequest(7, 9, 500'000, {}, 60'000 * kMs);  // 8 may be cut off
  EXPECT_EQ(writer.history().first_seq(), 6);
  writer.OnRequest(7, 9, 500'000, {}, 64'001 * kMs);  // and has been silent for long
  EXPECT_EQ(writer.history().first_seq(), 10);
}

TEST(OrderedWriter, KeepsFirstMessagesIfAHelloIsLost) {
  OrderedWriter writer = WriterOf(Retention::kUnacknowledged);
  writer.OnHello(7, 500'000, 0);
  for (int64_t n = 0; n < 3; ++n) writer.Sent(MessageOf(n), n * kMs);
  writer.OnRequest(7, 2, 500'000, {}, 5 * kMs);  // all known readers have everything
  EXPECT_EQ(writer.join_seq(2'900 * kMs), 0);
  const auto answer = writer.OnRequest(8, -1, 500'000, {{0, 2}}, 2'900 * kMs);
  ASSERT_EQ(answer.resend.size(), 3U) << "another has been listening all the time";
  writer.OnRequest(8, 2, 500'000, {}, 2'950 * kMs);
  writer.OnRequest(7, 2, 500'000, {}, 3'100 * kMs);
  EXPECT_EQ(writer.history().first_seq(), 3);
}

TEST(OrderedWriter, FirstMessagesAreBoundedByMemory) {
  OrderedWriter writer(Retention::kUnacknowledged, 10'000'000);
  for (int64_t n = 0; n < 2000; ++n) writer.Sent(MessageOf(n, 60'000), 0);
  EXPECT_LE(writer.history().memory_bytes(), 10'000'000);
}

TEST(OrderedWriter, SilentReaderIsOwedItsMessages) {
  OrderedWriter writer = WriterOf(Retention::kUnacknowledged);
  writer.KeepReadersFor(10'000 * kMs);
  writer.OnHello(7, 500'000, 0);
  writer.Sent(MessageOf(0), 0);
  EXPECT_FALSE(writer.AllDelivered(1'500 * kMs));
  EXPECT_TRUE(writer.AllDelivered(1'501 * kMs));
  EXPECT_FALSE(writer.AllDeliveredToSilent(10'000 * kMs)) << "its cable may be out";
  EXPECT_TRUE(writer.AllDeliveredToSilent(10'001 * kMs)) << "nothing is kept for it any more";
  writer.OnRequest(7, 0, 500'000, {}, 10'002 * kMs);
  EXPECT_TRUE(writer.AllDeliveredToSilent(10'003 * kMs));
}

TEST(OrderedWriter, NewReaderSkipsMessagesKeptForSilentReaders) {
  OrderedWriter writer = WriterOf(Retention::kUnacknowledged);
  writer.Sent(MessageOf(0), 0);
  writer.OnRequest(7, 0, 500'000, {}, 4'000 * kMs);
  writer.OnRequest(8, 0, 500'000, {}, 4'000 * kMs);
  for (int64_t n = 1; n < 10; ++n) writer.Sent(MessageOf(n), 4'000 * kMs);
  writer.OnRequest(7, 8, 500'000, {}, 5'000 * kMs);
  EXPECT_EQ(writer.join_seq(6'000 * kMs), 1) << "one that was heard 2 s ago: a newcomer may be that one, back again";
  writer.OnRequest(7, 8, 500'000, {}, 7'500 * kMs);
  EXPECT_EQ(writer.join_seq(7'500 * kMs), 9) << "where 7 stands";
  EXPECT_EQ(writer.history().first_seq(), 1) << "kept for 8";
  EXPECT_EQ(writer.join_seq(40'000 * kMs), 9) << "no reader is alive: the position of the last one";
  writer.OnHello(9, 500'000, 40'000 * kMs);
  EXPECT_EQ(writer.join_seq(40'000 * kMs), 9);
}

TEST(OrderedWriter, FirstReaderGetsTheWholeHistory) {
  OrderedWriter writer = WriterOf(Retention::kUnacknowledged);
  for (int64_t n = 0; n < 10; ++n) writer.Sent(MessageOf(n), 0);
  writer.OnHello(9, 500'000, 40'000 * kMs);
  EXPECT_EQ(writer.join_seq(40'000 * kMs), 0);
}

TEST(OrderedWriter, AnnouncesAfterSendingUntilAcknowledged) {
  OrderedWriter writer = WriterOf();
  writer.OnHello(7, 500'000, 0);
  const auto announcements = [&](int64_t from, int64_t to) {
    Numbers times;
    for (int64_t now = from; now < to; now += kMs) {
      if (writer.AnnounceDue(now)) times.push_back(now / kMs);
    }
    return times;
  };
  EXPECT_EQ(announcements(0, 500 * kMs), Numbers());
  writer.Sent(MessageOf(0), 500 * kMs);
  EXPECT_EQ(announcements(500 * kMs, 800 * kMs), (Numbers{503, 508, 518, 538, 578, 658}));
  writer.OnRequest(7, 0, 500'000, {}, 800 * kMs);
  writer.Sent(MessageOf(1), 800 * kMs);
  writer.OnRequest(7, 1, 500'000, {}, 801 * kMs);
  EXPECT_EQ(announcements(801 * kMs, 1700 * kMs), Numbers());
}

/// One writer and some readers over a network that loses, repeats and reorders; simulated time.
class LossyNetwork {
 public:
  LossyNetwork(double loss, uint64_t seed, Retention retention = Retention::kAll)
      : loss_(loss), random_(seed), retention_(retention) {}

  /// Sends n messages of random sizes; true when all readers have delivered all of them, in order, once.
  bool Run(int n, int n_readers, int64_t limit) {
    OrderedWriter writer = WriterOf(retention_);
    std::vector<OrderedReader> readers(static_cast<size_t>(n_readers), OrderedReader(true, 10'000'000, 0));
    std::vector<Numbers> delivered(readers.size());
    std::vector<int64_t> hello(readers.size(), 0);
    for (int64_t now = 0; now < limit; now += kMs / 5) {
      for (size_t r = 0; r < readers.size(); ++r) {
        if (now >= hello[r]) {
          hello[r] = now + 300 * kMs;
          ToWriter(now, [&, r, now] { writer.OnHello(SourceId(r + 1), 133'120, now); });
        }
      }
      if (writer.next_seq() < n && writer.WindowOpen(60'000, now)) {
        const Bytes message = MessageOf(writer.next_seq(), random_() % 3 == 0 ? 60'000 : 200);
        Multicast(now, readers, writer.next_seq(), message);
        writer.Sent(message, now);
      }
      if (writer.AnnounceDue(now)) Announce(now, readers, writer);
      Deliver(now);
      for (size_t r = 0; r < readers.size(); ++r) Poll(now, readers, r, writer, delivered[r]);
    }
    Numbers all(static_cast<size_t>(n));
    for (int i = 0; i < n; ++i) all[static_cast<size_t>(i)] = i;
    bool ok = true;
    for (size_t r = 0; r < readers.size(); ++r) {
      EXPECT_EQ(delivered[r].size(), all.size()) << "reader " << r;
      EXPECT_EQ(readers[r].lost(), readers[r].repaired());
      EXPECT_TRUE(delivered[r] == all) << "reader " << r << " got them out of order, twice, or not all";
      ok &= delivered[r] == all;
    }
    return ok;
  }

 private:
  struct Flight {
    int64_t at;
    std::function<void()> land;
  };

  void Send(int64_t now, std::function<void()> land) {
    if (Random() < loss_) return;
    flights_.push_back({now + static_cast<int64_t>(Random() * 0.5 * kMs), land});
    if (Random() < 0.02) flights_.push_back({now + 3 * kMs, std::move(land)});
  }
  void ToWriter(int64_t now, std::function<void()> land) { Send(now, std::move(land)); }

  void Multicast(int64_t now, std::vector<OrderedReader>& readers, int64_t seq, const Bytes& message) {
    for (OrderedReader& reader : readers) {
      Send(now, [this, &reader, seq, message] { reader.OnMessage(seq, *message, now_); });
    }
  }

  void Announce(int64_t now, std::vector<OrderedReader>& readers, const OrderedWriter& writer) {
    for (OrderedReader& reader : readers) {
      Send(now, [this, &reader, first = writer.history().first_seq(), join = writer.join_seq(now),
                 next = writer.next_seq()] { reader.OnAnnounce(first, next, now_, join); });
    }
  }

  void Poll(int64_t now, std::vector<OrderedReader>& readers, size_t r, OrderedWriter& writer, Numbers& delivered) {
    const Numbers more = Drain(readers[r], now);
    delivered.insert(delivered.end(), more.begin(), more.end());
    const auto request = readers[r].Poll(now);
    if (!request) return;
    ToWriter(now, [this, &readers, &writer, r, request] {
      const auto answer = writer.OnRequest(SourceId(r + 1), request->delivered, 133'120, request->ranges, now_);
      for (const History::Kept& kept : answer.resend) Multicast(now_, readers, NumberOf(kept.message), kept.message);
      if (answer.announce) Announce(now_, readers, writer);
    });
  }

  void Deliver(int64_t now) {
    now_ = now;
    std::vector<Flight> landing;
    for (auto flight = flights_.begin(); flight != flights_.end();) {
      if (flight->at > now) {
        ++flight;
        continue;
      }
      landing.push_back(std::move(*flight));
      flight = flights_.erase(flight);
    }
    for (Flight& flight : landing) flight.land();
  }

  double Random() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  double loss_;
  std::mt19937_64 random_;
  Retention retention_;
  std::deque<Flight> flights_;
  int64_t now_ = 0;
};

class OrderedChannel : public testing::TestWithParam<double> {};

TEST_P(OrderedChannel, EveryMessageArrivesOnceAndInOrder) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    EXPECT_TRUE(LossyNetwork(GetParam(), seed).Run(200, 2, 60'000 * kMs)) << "seed " << seed;
  }
}

TEST_P(OrderedChannel, EveryMessageArrivesIfHistoryIsDropped) {
  for (uint64_t seed = 1; seed <= 20; ++seed) {
    EXPECT_TRUE(LossyNetwork(GetParam(), seed, Retention::kUnacknowledged).Run(50, 2, 20'000 * kMs))
        << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Loss, OrderedChannel, testing::Values(0.0, 0.05, 0.2, 0.5));

}  // namespace
}  // namespace plslam::bus
