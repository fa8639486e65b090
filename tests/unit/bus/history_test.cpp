// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/history.h"

#include <sys/stat.h>

#include <filesystem>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/bus/bus_fixture.h"
#include "tests/unit/bus/numbered_messages.h"

namespace plslam::bus {
namespace {

using test::MessageOf;
using test::NumberOf;

/// A history and its log, as a bus uses them.
struct LoggedHistory {
  LoggedHistory(int64_t memory_bytes, const std::string& path, bool keep_file,
                int64_t disk_bytes = History::kDiskBytes)
      : history(Retention::kAll, memory_bytes, disk_bytes), log("CHANNEL", path, keep_file) {}

  void Append(Bytes message) {
    history.Append(std::move(message));
    while (const Bytes oldest = history.ToMove()) log.Release(history.Moved(log.Write(oldest)));
  }
  Bytes Get(int64_t seq) {
    const std::optional<History::Kept> kept = history.Find(seq);
    if (!kept) return nullptr;
    const Bytes message = kept->message != nullptr ? kept->message : log.Read(kept->offset);
    EXPECT_EQ(message->size(), kept->bytes);
    return message;
  }

  History history;
  HistoryLog log;
};

TEST(History, MovesToALogAndReadsItBack) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "deep/CHANNEL.lcmlog";
  {
    LoggedHistory kept(10'000, path, false);
    for (int64_t n = 0; n < 1000; ++n) kept.Append(MessageOf(n, 100 + static_cast<size_t>(n % 50)));
    EXPECT_LE(kept.history.memory_bytes(), 10'000);
    EXPECT_GT(kept.history.moved(), 900);
    EXPECT_EQ(kept.history.first_seq(), 0);
    EXPECT_EQ(kept.history.next_seq(), 1000);
    for (const int64_t n : {0, 1, 500, 7, 950, 999}) {
      const Bytes message = kept.Get(n);
      ASSERT_NE(message, nullptr) << n;
      EXPECT_EQ(*message, *MessageOf(n, 100 + static_cast<size_t>(n % 50)));
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "deep")) << "a process that is killed can remove nothing";
    kept.Append(MessageOf(1000));
    EXPECT_EQ(NumberOf(kept.Get(920)), 920);
    EXPECT_EQ(kept.Get(1001), nullptr);
    EXPECT_EQ(kept.Get(-1), nullptr);
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(History, IsReadWhileAnotherThreadWrites) {
  const test::TemporaryFolder folder;
  HistoryLog log("CHANNEL", folder / "CHANNEL.lcmlog", true);
  std::mutex mutex;
  std::vector<int64_t> offsets;
  std::thread writer([&] {
    for (int64_t n = 0; n < 2000; ++n) {
      const std::optional<int64_t> offset = log.Write(MessageOf(n, 3000));
      ASSERT_TRUE(offset);
      const std::lock_guard lock(mutex);
      offsets.push_back(*offset);
    }
  });
  for (int64_t seen = 0; seen < 2000;) {
    int64_t offset = -1;
    {
      const std::lock_guard lock(mutex);
      seen = static_cast<int64_t>(offsets.size());
      if (seen > 0) offset = offsets.back();
    }
    if (offset < 0) continue;
    ASSERT_EQ(NumberOf(log.Read(offset)), seen - 1);
  }
  writer.join();
}

TEST(History, KeepsItsLogIfRequested) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "CHANNEL.lcmlog";
  {
    LoggedHistory kept(1000, path, true);
    for (int64_t n = 0; n < 100; ++n) kept.Append(MessageOf(n));
  }
  EXPECT_TRUE(std::filesystem::exists(path));
}

TEST(History, DiskIsBounded) {
  const test::TemporaryFolder folder;
  const std::string path = folder / "CHANNEL.lcmlog";
  LoggedHistory kept(1'000'000, path, true, 20'000'000);
  static constexpr int64_t kMessages = 600;
  for (int64_t n = 0; n < kMessages; ++n) kept.Append(MessageOf(n, 100'000));
  const int64_t first = kept.history.first_seq();
  EXPECT_NEAR(static_cast<double>(first), 400.0, 5.0) << "20 of 60 MB are kept";
  EXPECT_EQ(kept.Get(first - 1), nullptr);
  for (const int64_t n : {first, first + 100, kMessages - 1}) EXPECT_EQ(NumberOf(kept.Get(n)), n);
  struct stat status {};
  ASSERT_EQ(stat(path.c_str(), &status), 0);
  EXPECT_LT(status.st_blocks * 512, 40'000'000) << "16 MB are released at a time";
  EXPECT_EQ(kept.log.Read(0), nullptr) << "released";
}

TEST(History, DropsOldMessagesIfTheDiskIsNotWritable) {
  LoggedHistory kept(1000, "/proc/nowhere/CHANNEL.lcmlog", false);
  for (int64_t n = 0; n < 100; ++n) kept.Append(MessageOf(n));
  EXPECT_EQ(kept.history.first_seq(), 90);
  EXPECT_EQ(kept.Get(5), nullptr);
  EXPECT_EQ(NumberOf(kept.Get(95)), 95);
}

TEST(History, UnacknowledgedHistoryIsBounded) {
  History history(Retention::kUnacknowledged, 1000);
  for (int64_t n = 0; n < 100; ++n) history.Append(MessageOf(n));
  EXPECT_EQ(history.ToMove(), nullptr);
  EXPECT_EQ(history.first_seq(), 90);
  history.Forget(95);
  EXPECT_EQ(history.first_seq(), 95);
  EXPECT_FALSE(history.Find(94));
}

}  // namespace
}  // namespace plslam::bus
