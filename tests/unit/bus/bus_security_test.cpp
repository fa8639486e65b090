// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <mutex>
#include <random>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include "core/bus/bus.h"
#include "core/bus/transport/authenticator.h"
#include "core/bus/transport/transport.h"
#include "plslam/announce_t.hpp"
#include "plslam/pose_t.hpp"
#include "plslam/repair_request_t.hpp"
#include "tests/unit/bus/bus_fixture.h"
#include "tests/unit/bus/random_message.h"

namespace plslam::bus {
namespace {

using test::Eventually;
using test::PrivateUrl;
using test::RunningBus;
using test::TemporaryFolder;
using test::Waiter;

/// Channels and bytes.
using Messages = std::vector<std::pair<std::string, std::vector<uint8_t>>>;

/// A URL, a key, and a raw sender that can put anything on the wire.
class BusSecurity : public testing::Test {
 protected:
  std::string KeyFile(char digit) const {
    std::string path = folder_ / (std::string("key_") + digit);
    std::ofstream(path) << std::string(64, digit) << '\n';
    return path;
  }
  BusOptions Options(const std::string& key_file = "") const {
    BusOptions options;
    options.url = url_;
    options.key_file = key_file;
    return options;
  }
  static std::vector<uint8_t> Encoded(int64_t source, int64_t seq) {
    pose_t pose{};
    pose.header.schema = kSchemaVersion;
    pose.header.source = source;
    pose.header.seq = seq;
    pose.frame_id = seq;
    return Encode(pose);
  }
  template <class T>
  static std::vector<uint8_t> Encode(const T& message) {
    std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
    message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
    return bytes;
  }

  /// Sends recorded messages again.
  void Replay(const Messages& recording, int rounds) {
    for (int round = 0; round < rounds; ++round) {
      for (const auto& [channel, bytes] : recording) wire_.Send(channel, bytes);
    }
  }

  const TemporaryFolder folder_;
  const std::string url_ = PrivateUrl();
  Transport wire_{url_};
};

TEST_F(BusSecurity, SameKeyIsAcceptedOthersAreRejected) {
  Waiter received;
  RunningBus reader(Options(KeyFile('a')), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, 1);
    received.Add();
  });
  reader.Start();
  Bus stranger(Options(KeyFile('b')), "stranger");
  Bus open(Options(), "open");
  Bus friendly(Options(KeyFile('a')), "friend");
  pose_t pose{};
  pose.frame_id = 2;
  stranger.Publish(kPose, pose);
  open.Publish(kPose, pose);
  ASSERT_TRUE(Eventually([&] { return reader->counters().rejected >= 2; }));
  pose.frame_id = 1;
  friendly.Publish(kPose, pose);
  ASSERT_TRUE(received.Reaches(1));
}

TEST_F(BusSecurity, KeyReadableByOthersGivesAWarning) {
  const std::string key = KeyFile('a');
  const auto warning = [&](mode_t mode) {
    chmod(key.c_str(), mode);
    std::ostringstream log;
    const auto before = spdlog::default_logger();
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
    const Authenticator authenticator(key);
    spdlog::set_default_logger(before);
    return log.str();
  };
  EXPECT_THAT(warning(0644),
              testing::HasSubstr(key + " is accessible to users other than its owner (mode 0644): chmod 600 " + key));
  EXPECT_THAT(warning(0640), testing::HasSubstr("mode 0640"));
  EXPECT_EQ(warning(0600), "");
  EXPECT_EQ(warning(0400), "");
}

TEST_F(BusSecurity, SignedAndUnsignedAreAcceptedWithoutAKey) {
  Waiter received;
  RunningBus reader(Options(), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  Bus keyed(Options(KeyFile('a')), "keyed");
  Bus open(Options(), "open");
  keyed.Publish(kPose, pose_t{});
  open.Publish(kPose, pose_t{});
  EXPECT_TRUE(received.Reaches(2));
}

TEST_F(BusSecurity, AnyChangedBitIsRejected) {
  const Authenticator authenticator(KeyFile('a'));
  auto bytes = Encoded(1, 0);
  const size_t length = bytes.size();
  authenticator.Append("POSE", bytes);
  ASSERT_EQ(bytes.size(), length + Authenticator::kMacBytes);
  EXPECT_TRUE(authenticator.Accept("POSE", bytes, length));
  EXPECT_FALSE(authenticator.Accept("POSF", bytes, length)) << "a message of one channel replayed on another";
  EXPECT_FALSE(authenticator.Accept("POSE", ByteView(bytes).first(length), length)) << "MAC cut off";
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
    EXPECT_FALSE(authenticator.Accept("POSE", bytes, length)) << bit;
    bytes[bit / 8] ^= static_cast<uint8_t>(1 << (bit % 8));
  }
}

TEST_F(BusSecurity, SequenceNumbersNearTheMaximumAreRejected) {
  Waiter received;
  RunningBus reader(Options(), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  wire_.Send("POSE", Encoded(7, INT64_MAX));
  wire_.Send("POSE", Encoded(7, kMaxNumber + 1));
  EXPECT_TRUE(Eventually([&] { return reader->counters().rejected == 2; }));
  wire_.Send("POSE", Encoded(7, 0));
  EXPECT_TRUE(received.Reaches(1));
}

TEST_F(BusSecurity, BadKeyFilesAreRefused) {
  for (const std::string text : {"", "12", "zz", "0123456789abcdef", "not a key at all"}) {
    const std::string path = folder_ / "bad";
    std::ofstream(path) << text;
    EXPECT_THROW(Authenticator{path}, std::runtime_error) << text;
  }
  std::ofstream(folder_ / "two") << std::string(64, 'a') << ' ' << std::string(64, 'b');
  EXPECT_THROW(Authenticator{folder_ / "two"}, std::runtime_error);
}

TEST_F(BusSecurity, ReplayedMessagesAreDroppedAndCounted) {
  Waiter received;
  RunningBus reader(Options(), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  for (int i = 0; i < 3; ++i) wire_.Send("POSE", Encoded(42, 0));
  wire_.Send("POSE", Encoded(42, 1));
  ASSERT_TRUE(received.Reaches(2));
  ASSERT_TRUE(Eventually([&] { return reader->counters().duplicates == 2; }));
  EXPECT_EQ(received.value(), 2);
}

/// Records everything on the wire during its lifetime.
class Eavesdropper {
 public:
  explicit Eavesdropper(const std::string& url) : bus_(Options(url), "eavesdropper") {
    bus_->SubscribeRest([this](std::string_view channel, ByteView bytes) {
      const std::lock_guard lock(mutex_);
      heard_.emplace_back(std::string(channel), std::vector<uint8_t>(bytes.begin(), bytes.end()));
    });
    bus_.Start();
  }
  Messages heard(const std::string& channel = "") const {
    const std::lock_guard lock(mutex_);
    Messages messages;
    for (const auto& message : heard_) {
      if (channel.empty() || message.first == channel) messages.push_back(message);
    }
    return messages;
  }

 private:
  static BusOptions Options(const std::string& url) {
    BusOptions options;
    options.url = url;
    return options;
  }
  mutable std::mutex mutex_;
  Messages heard_;
  RunningBus bus_;
};

TEST_F(BusSecurity, ReplayedMessagesOfAnExitedPublisher) {
  Eavesdropper eavesdropper(url_);
  {
    Waiter received;
    RunningBus reader(Options(KeyFile('a')), "reader");
    reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
    reader.Start();
    Bus publisher(Options(KeyFile('a')), "publisher");
    for (int i = 0; i < 5; ++i) publisher.Publish(kPose, pose_t{});
    ASSERT_TRUE(received.Reaches(5));
    ASSERT_TRUE(Eventually([&] { return eavesdropper.heard("POSE").size() >= 5; }));
  }
  const auto recording = eavesdropper.heard();
  std::vector<int64_t> frames;
  Waiter received;
  RunningBus reader(Options(KeyFile('a')), "reader, started again");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    frames.push_back(pose.frame_id);
    received.Add();
  });
  reader.Start();
  Replay(recording, 3);
  ASSERT_TRUE(Eventually([&] { return reader->counters().unproven >= 15; })) << reader->counters().unproven;
  Bus publisher(Options(KeyFile('a')), "publisher, started again");
  pose_t pose{};
  pose.frame_id = 77;
  publisher.Publish(kPose, pose);
  ASSERT_TRUE(received.Reaches(1));
  reader.Join();
  EXPECT_EQ(frames, std::vector<int64_t>{77});
}

TEST_F(BusSecurity, ReplayedRequestsDoNotReviveAReader) {
  Eavesdropper eavesdropper(url_);
  {
    RunningBus reader(Options(KeyFile('a')), "reader");
    reader->Subscribe<pose_t>(kPose, [](const pose_t&) {});
    reader.Start();
    ASSERT_TRUE(Eventually([&] { return !eavesdropper.heard("REPAIR_REQUEST").empty(); }));
  }
  Bus publisher(Options(KeyFile('a')), "publisher");
  const auto recording = eavesdropper.heard("REPAIR_REQUEST");
  Replay(recording, 20);
  ASSERT_TRUE(Eventually([&] { return publisher.counters().duplicates >= 19; }));
  EXPECT_EQ(publisher.ReaderCount(kPose), 0);
}

TEST_F(BusSecurity, RequestsCountOnceWithAKey) {
  Eavesdropper eavesdropper(url_);
  Waiter received;
  RunningBus reader(Options(KeyFile('a')), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  Bus publisher(Options(KeyFile('a')), "publisher");
  for (int i = 0; i < 50; ++i) publisher.Publish(kPose, pose_t{});
  ASSERT_TRUE(received.Reaches(50));
  ASSERT_TRUE(Eventually([&] { return !eavesdropper.heard("REPAIR_REQUEST").empty(); }));
  const int64_t resent = publisher.counters().resent, duplicates = publisher.counters().duplicates;
  int64_t replayed = 0;
  const auto recording = eavesdropper.heard();
  for (int round = 0; round < 2; ++round) {  // hellos from before the publisher began are new to it, once
    for (const auto& [channel, bytes] : recording) {
      if (channel != "REPAIR_REQUEST" && channel != "POSE") continue;
      wire_.Send(channel, bytes);
      if (round == 0) replayed += channel == "REPAIR_REQUEST" && ReadHeader(bytes).source == reader->source() ? 1 : 0;
    }
  }
  ASSERT_TRUE(Eventually([&] { return publisher.counters().duplicates >= duplicates + replayed; }));
  EXPECT_EQ(publisher.counters().resent, resent);
  EXPECT_EQ(received.value(), 50);
}

TEST_F(BusSecurity, WarningsNameTheRejectionInOneLine) {
  RunningBus reader(Options(KeyFile('a')), "reader");
  reader->Subscribe<pose_t>(kPose, [](const pose_t&) {});
  reader.Start();
  EXPECT_EQ(reader->Problems(), "");
  auto other_version = Encoded(42, 0);
  other_version[3] ^= 1;  // LCM's fingerprint of the type
  wire_.Send("POSE", other_version);
  wire_.Send("POSE", Encoded(42, 0));
  wire_.Send("robot2/STATUS", Encoded(42, 0));
  ASSERT_TRUE(Eventually([&] { return reader->Problems().find("robot2/") != std::string::npos; }));
  EXPECT_EQ(reader->Problems(),
            "messages rejected: 1 of another version (POSE), 1 without bus.key_file (POSE); processes with prefix "
            "'robot2/' were found, too");
}

TEST_F(BusSecurity, MalformedDatagramsAreRejectedAndHarmless) {
  Waiter received;
  RunningBus reader(Options(), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t&) { received.Add(); });
  reader.Start();
  std::vector<std::vector<uint8_t>> bad = {
      {}, {1, 2, 3}, std::vector<uint8_t>(62'000, 7), Encoded(0, 0), Encoded(1, -1)};
  auto message = Encoded(42, 0);
  bad.emplace_back(message.begin(), message.end() - 1);
  message.push_back(0);
  bad.push_back(message);
  auto schema = Encoded(42, 0);
  schema[11] = 99;
  bad.push_back(schema);
  for (const auto& bytes : bad) wire_.Send("POSE", bytes);
  wire_.Send("POSE", std::vector<uint8_t>(300'000, 7));  // LCM itself cuts and joins it
  ASSERT_TRUE(Eventually([&] { return reader->counters().rejected >= static_cast<int64_t>(bad.size()); }))
      << reader->counters().rejected;
  wire_.Send("POSE", Encoded(42, 0));
  EXPECT_TRUE(received.Reaches(1));
}

TEST_F(BusSecurity, FalseRequestsAndAnnouncementsAreHarmless) {
  Waiter received;
  int64_t next = 0;
  RunningBus reader(Options(), "reader");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) {
    EXPECT_EQ(pose.frame_id, next++);
    received.Add();
  });
  reader.Start();
  Bus publisher(Options(), "publisher");
  ASSERT_TRUE(test::WaitForReaders(publisher, kPose, 1));
  publisher.Publish(kPose, pose_t{});
  std::mt19937_64 random(1);
  for (int i = 0; i < 300; ++i) {
    repair_request_t request{};
    request.header.schema = kSchemaVersion;
    request.header.source = 1 + static_cast<int64_t>(random() % 1000);
    request.header.seq = i;
    request.channel = i % 3 == 0 ? "POSE" : "NOWHERE";
    request.publisher = i % 2 == 0 ? publisher.source().value : 0;
    request.delivered = static_cast<int64_t>(random());
    request.window_bytes = static_cast<int32_t>(random());
    range_t range{};
    range.first = static_cast<int64_t>(random());
    range.last = INT64_MAX;
    request.ranges.assign(5, range);
    request.n_ranges = 5;
    wire_.Send("REPAIR_REQUEST", Encode(request));
    announce_t announce{};
    announce.header = request.header;
    announce.channel = "POSE";
    announce.first_seq = static_cast<int64_t>(random());
    announce.next_seq = static_cast<int64_t>(random());
    wire_.Send("ANNOUNCE", Encode(announce));
  }
  for (int i = 1; i < 100; ++i) {
    pose_t pose{};
    pose.frame_id = i;
    publisher.Publish(kPose, pose);
  }
  EXPECT_TRUE(received.Reaches(100)) << received.value();
}

TEST_F(BusSecurity, RandomMessagesOfEveryTypeOnEveryChannel) {
  Waiter received;
  RunningBus reader(Options(), "reader");
  for (const Channel& channel : Channels()) {
    reader->SubscribeBytes(
        channel, Bus::Reading::kOrdered, [] { return true; }, [](ByteView) {});
  }
  reader.Start();
  std::mt19937_64 random(5);
  for (int i = 0; i < 2000; ++i) {
    const Channel& channel = Channels()[random() % Channels().size()];
    auto bytes = test::RandomMessage(*FindMessageLayout(channel.type), random);
    for (uint64_t n = random() % 3; n > 0; --n) bytes[random() % bytes.size()] = static_cast<uint8_t>(random());
    wire_.Send(std::string(channel.name), bytes);
  }
  RunningBus publisher(Options(), "publisher");
  reader->Subscribe<pose_t>(kPose, [&](const pose_t& pose) { received.Add(pose.frame_id == 77 ? 1 : 0); });
  pose_t pose{};
  pose.frame_id = 77;
  publisher->Publish(kPose, pose);
  EXPECT_TRUE(received.Reaches(1));
}

}  // namespace
}  // namespace plslam::bus
