// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/message_times.h"

#include <gtest/gtest.h>

#include <set>

#include "core/files/dataset_error.h"

namespace plslam {
namespace {

constexpr int64_t kMillisecond_ns = 1'000'000;
constexpr int kMessages = 3000;

/// A recording of two topics in chunks that take long to decompress, of two messages each: one of each topic.
class LargeRecording : public Recording {
 public:
  explicit LargeRecording(int64_t (*delay)(int message)) : delay_(delay) {}

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override {
    std::vector<RecordedMessage> messages;
    for (int i = 0; i < kMessages; ++i) {
      const uint64_t offset = topic == "right" ? 100 : 0;
      messages.push_back({Stamp(i) + delay_(i), RecordedMessage::kNotRead, static_cast<uint32_t>(i), offset});
    }
    return messages;
  }
  plslam::Notes Notes() const override { return {}; }
  double scan_s() const override { return 0.0; }
  std::vector<uint8_t> Read(const RecordedMessage&) const override { return {}; }
  std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const override {
    chunks_read_.insert(message.chunk);
    const int64_t stamp_ns = Stamp(static_cast<int>(message.chunk));
    std::vector<uint8_t> bytes(n);
    const auto put = [&](size_t at, int64_t value) {
      for (size_t i = 0; i < 4; ++i) bytes.at(at + i) = static_cast<uint8_t>(value >> (8 * i));
    };
    put(4, stamp_ns / 1'000'000'000);
    put(8, stamp_ns % 1'000'000'000);
    return bytes;
  }
  void WillReadBegin(const RecordedMessage&, uint64_t) const override {}
  uint64_t DecompressionCost(uint32_t) const override { return 1 << 20; }

  static int64_t Stamp(int message) { return 1'700'000'000'000'000'000 + 50 * kMillisecond_ns * message; }
  size_t n_chunks_read() const { return chunks_read_.size(); }

 private:
  int64_t (*delay_)(int message);
  std::vector<RecordedChannel> channels_;
  mutable std::set<uint32_t> chunks_read_;
};

/// Returns the number of chunks that are read for the stamps, which are right within `error_ns`.
size_t ChunksRead(int64_t (*delay)(int message), int64_t error_ns) {
  const LargeRecording recording(delay);
  std::vector<RecordedMessage> left = recording.Messages("left"), right = recording.Messages("right");
  ReadStamps(recording, {&left, &right}, 6 * kMillisecond_ns);
  for (const auto& messages : {left, right}) {
    for (int i = 0; i < kMessages; ++i) {
      EXPECT_NEAR(static_cast<double>(messages[static_cast<size_t>(i)].stamp_ns - LargeRecording::Stamp(i)), 0.0,
                  static_cast<double>(error_ns))
          << i;
    }
  }
  return recording.n_chunks_read();
}

TEST(MessageTimes, StampsOfLargeRecordingsFollowFromAFew) {
  EXPECT_LT(ChunksRead([](int) { return 7 * kMillisecond_ns; }, 0), 50U);
  EXPECT_LT(
      ChunksRead([](int i) { return 111'000 * kMillisecond_ns + i % 5 * kMillisecond_ns; }, 5 * kMillisecond_ns),
      50U);
  EXPECT_LT(ChunksRead([](int i) { return i * kMillisecond_ns / 100; }, 2 * kMillisecond_ns), 50U)
      << "the clocks drift";
}

TEST(MessageTimes, StampsAreReadIfTheRecorderWasBusy) {
  EXPECT_LT(ChunksRead([](int i) { return i > 1500 && i < 1510 ? (1510 - i) * 50 * kMillisecond_ns : 0; }, 0), 100U);
  EXPECT_LT(ChunksRead([](int i) { return i > 1500 && i < 1600 ? (i - 1500) * 11 * kMillisecond_ns : 0; },
                       6 * kMillisecond_ns),
            300U);
}

TEST(MessageTimes, AllStampsAreReadIfLogTimesAreUseless) {
  EXPECT_EQ(ChunksRead([](int i) { return i * 13 % 50 * kMillisecond_ns; }, 0), size_t{kMessages});
  EXPECT_EQ(ChunksRead([](int i) { return -(i * 50 * kMillisecond_ns); }, 0), size_t{kMessages})
      << "all are logged at one time";
}

}  // namespace
}  // namespace plslam
