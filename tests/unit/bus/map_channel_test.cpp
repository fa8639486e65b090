// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/map_channel.h"

#include <atomic>
#include <memory>

#include <gtest/gtest.h>

#include "plslam/map_request_t.hpp"
#include "tests/unit/bus/bus_fixture.h"
#include "tests/unit/bus/map_owner.h"

namespace plslam::bus {
namespace {

using test::EncodedMap;
using test::MapOwner;
using test::RunningBus;
using test::Waiter;

BusOptions PrivateOptions() {
  BusOptions options;
  options.url = test::PrivateUrl();
  return options;
}

/// A small mapping_process: it publishes versions, and the complete map on request, on the thread of the bus.
class Publisher {
 public:
  Publisher(const BusOptions& options, uint64_t seed)
      : owner_(seed), bus_(options, "mapping"), publisher_(*bus_, [this] {
          publisher_.Publish(owner_.Whole());
          asked_.Add();
        }) {
    bus_.Start();
  }
  ~Publisher() { bus_.Join(); }

  /// `n` versions after `steps` changes each; waits until they are out.
  void Publish(int n, int steps) {
    const int64_t before = published_.value();
    bus_->Post([this, n, steps] {
      for (int i = 0; i < n; ++i) publisher_.Publish(owner_.Next(steps));
      published_.Add(n);
    });
    ASSERT_TRUE(published_.Reaches(before + n));
  }

  Bus& bus() { return *bus_; }
  Waiter& asked() { return asked_; }
  /// To be called only while nothing is published.
  const MapOwner& owner() const { return owner_; }

 private:
  MapOwner owner_;
  Waiter asked_;
  Waiter published_;
  RunningBus bus_;
  MapUpdatePublisher publisher_;
};

/// A listener with its copy of the map.
class Listener {
 public:
  explicit Listener(const BusOptions& options)
      : bus_(options, "viewer"), subscriber_(*bus_, [this](const MapUpdate& update) {
          const MapFollower& replica = subscriber_.follower();
          EXPECT_EQ(update.totals, replica.map().Totals());
          source_ = replica.version()->numbering;
          version_ = replica.version()->number;
        }) {
    bus_.Start();
  }
  ~Listener() { bus_.Join(); }

  bool Reaches(SourceId source, int64_t version) {
    return test::Eventually([&] { return source_ == source && version_ == version; });
  }

  /// Ends the listening.
  std::vector<uint8_t> Map() {
    bus_.Join();
    return EncodedMap(subscriber_.follower().map());
  }

  Bus& bus() { return *bus_; }

 private:
  std::atomic<SourceId> source_;
  std::atomic<int64_t> version_ = 0;
  RunningBus bus_;
  MapSubscriber subscriber_;
};

void ExpectSameMap(Listener& listener, Publisher& publisher) {
  ASSERT_TRUE(listener.Reaches(publisher.bus().source(), publisher.owner().version()));
  EXPECT_EQ(listener.Map(), EncodedMap(publisher.owner().map()));
}

TEST(MapChannel, EarlyAndLateListenersHaveTheSameMap) {
  for (uint64_t seed = 1; seed <= 5; ++seed) {
    const BusOptions options = PrivateOptions();
    Listener early(options);
    Publisher publisher(options, seed);
    ASSERT_TRUE(test::WaitForReaders(publisher.bus(), kMapUpdate, 1));
    publisher.Publish(20, 30);
    Listener late(options);
    publisher.Publish(20, 30);
    ASSERT_TRUE(late.Reaches(publisher.bus().source(), 40));
    Listener at_the_end(options);
    ExpectSameMap(early, publisher);
    ExpectSameMap(late, publisher);
    ExpectSameMap(at_the_end, publisher);
  }
}

TEST(MapChannel, ALossyNetworkChangesNothing) {
  BusOptions options = PrivateOptions();
  options.max_message_bytes = 1200;
  options.drop_fraction = 0.05;
  Listener early(options);
  Publisher publisher(options, 9);
  ASSERT_TRUE(test::WaitForReaders(publisher.bus(), kMapUpdate, 1));
  publisher.Publish(20, 30);
  Listener late(options);
  publisher.Publish(20, 30);
  ExpectSameMap(early, publisher);
  ExpectSameMap(late, publisher);
}

TEST(MapChannel, AListenerThatHasLostItsCopyGetsItAgain) {
  const BusOptions options = PrivateOptions();
  Publisher publisher(options, 3);
  for (int i = 0; i < 3; ++i) {
    Listener listener(options);
    publisher.Publish(5, 40);
    ExpectSameMap(listener, publisher);
  }
}

TEST(MapChannel, MappingStartedAgainIsFollowed) {
  const BusOptions options = PrivateOptions();
  Listener listener(options);
  auto before = std::make_unique<Publisher>(options, 5);
  before->Publish(10, 40);
  ASSERT_TRUE(listener.Reaches(before->bus().source(), 10));
  before.reset();
  Publisher after(options, 6);
  after.Publish(4, 40);
  ExpectSameMap(listener, after);
}

TEST(MapChannel, UpdatesOfAnOlderMapperAreIgnored) {
  const BusOptions options = PrivateOptions();
  Listener listener(options);
  Publisher older(options, 5);
  older.Publish(3, 40);
  ASSERT_TRUE(listener.Reaches(older.bus().source(), 3));
  Publisher newer(options, 6);
  newer.Publish(3, 40);
  ASSERT_TRUE(listener.Reaches(newer.bus().source(), 3));
  older.Publish(3, 40);
  newer.Publish(3, 40);
  ExpectSameMap(listener, newer);
}

TEST(MapChannel, OnlyTheNamedPublisherWithAMapAnswers) {
  const BusOptions options = PrivateOptions();
  Publisher empty(options, 1), full(options, 2);
  full.Publish(2, 40);
  RunningBus asker(options);
  asker.Start();
  const auto ask = [&](SourceId publisher, int64_t version) {
    map_request_t request{};
    request.publisher = publisher.value;
    request.version = version;
    asker->Publish(kMapRequest, request);
  };
  // The newest request replaces earlier ones: each must have been received before the next.
  const auto ask_and_wait = [&](SourceId publisher, int64_t version) {
    const int64_t before = full.bus().counters().received;
    ask(publisher, version);
    return test::Eventually([&] { return full.bus().counters().received > before; });
  };
  ASSERT_TRUE(ask_and_wait(full.bus().source(), 2)) << "has it all";
  ASSERT_TRUE(ask_and_wait(12345, 0)) << "another publisher";
  ask(0, 0);
  ASSERT_TRUE(full.asked().Reaches(1));
  ask(full.bus().source(), 1);
  ASSERT_TRUE(full.asked().Reaches(2));
  EXPECT_EQ(full.asked().value(), 2);
  EXPECT_EQ(empty.asked().value(), 0);
}

}  // namespace
}  // namespace plslam::bus
