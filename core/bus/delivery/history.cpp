// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/history.h"

#include <fcntl.h>

#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include <lcm/eventlog.h>

#include "core/bus/transport/wall_clock.h"
#include "core/files/mapped_file.h"

namespace plslam::bus {
namespace {

using LogHandle = std::unique_ptr<lcm_eventlog_t, void (*)(lcm_eventlog_t*)>;

/// A history with a log has this part of its memory.
constexpr int64_t kLoggedShare = 8;
/// First byte of an event in a log of LCM; zero where the log was released.
constexpr int kFirstByte = 0xed;
/// So much is released at a time.
constexpr int64_t kRelease = 16'000'000;

LogHandle OpenLog(const std::string& path, const char* mode) {
  return LogHandle(lcm_eventlog_create(path.c_str(), mode), &lcm_eventlog_destroy);
}

}  // namespace

std::string TemporaryFolder(SourceId source) { return TemporaryRoot() + "/plslam-" + std::to_string(source.value); }

void History::Append(Bytes message) {
  bytes_ += static_cast<int64_t>(message->size());
  memory_.push_back(std::move(message));
  if (UsesLog()) return;
  const int64_t limit = retention_ == Retention::kNone ? 0 : memory_limit_;
  while (bytes_ > limit && memory_.size() > 1) DropOldest();
}

Bytes History::ToMove() const {
  return UsesLog() && bytes_ > memory_limit_ / kLoggedShare && memory_.size() > 1 ? memory_.front() : nullptr;
}

int64_t History::Moved(std::optional<int64_t> offset) {
  if (!offset) {
    log_failed_ = true;
    moved_.clear();
    DropOldest();
    return 0;
  }
  moved_.push_back({*offset, memory_.front()->size()});
  moved_bytes_ += static_cast<int64_t>(moved_.back().bytes);
  const int64_t first = first_seq_;
  DropOldest();
  first_seq_ = first;
  for (; moved_bytes_ > disk_limit_ && moved_.size() > 1; ++first_seq_) {
    moved_bytes_ -= static_cast<int64_t>(moved_.front().bytes);
    moved_.pop_front();
  }
  return moved_.front().offset;
}

void History::DropOldest() {
  bytes_ -= static_cast<int64_t>(memory_.front()->size());
  memory_.pop_front();
  first_seq_ = ++memory_first_;
}

std::optional<History::Kept> History::Find(int64_t seq) const {
  if (seq < first_seq_ || seq >= next_seq()) return std::nullopt;
  if (seq >= memory_first_) {
    const Bytes& message = memory_[static_cast<size_t>(seq - memory_first_)];
    return Kept{message, -1, message->size()};
  }
  const Place& place = moved_[static_cast<size_t>(seq - first_seq_)];
  return Kept{nullptr, place.offset, place.bytes};
}

void History::Forget(int64_t seq) {
  if (retention_ == Retention::kAll) return;
  while (memory_first_ < seq && !memory_.empty()) DropOldest();
}

struct HistoryLog::Files {
  LogHandle writer;
  LogHandle reader;
};

HistoryLog::HistoryLog(std::string channel, std::string path, bool keep_file)
    : channel_(std::move(channel)), path_(std::move(path)), keep_file_(keep_file) {}

HistoryLog::~HistoryLog() = default;

std::optional<int64_t> HistoryLog::Write(const Bytes& message) {
  if (files_ == nullptr) {
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(path_).parent_path(), ignored);
    files_ = std::make_unique<Files>(Files{OpenLog(path_, "w"), OpenLog(path_, "r")});
    if (!keep_file_) RemoveFile();
  }
  lcm_eventlog_t* writer = files_->writer.get();
  const int64_t offset = writer != nullptr ? ftello(writer->f) : -1;
  lcm_eventlog_event_t event{};
  event.timestamp = WallClock_us();
  event.channellen = static_cast<int32_t>(channel_.size());
  event.channel = channel_.data();
  event.datalen = static_cast<int32_t>(message->size());
  event.data = const_cast<uint8_t*>(message->data());  // LCM's C interface is not const-correct
  // Flushed at once: the reader has a separate handle.
  const bool written = offset >= 0 && files_->reader != nullptr && lcm_eventlog_write_event(writer, &event) == 0 &&
                       fflush(writer->f) == 0;
  return written ? std::optional(offset) : std::nullopt;
}

/// An open file stays readable without its name, and is removed with the process however that ends.
void HistoryLog::RemoveFile() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  std::filesystem::remove(std::filesystem::path(path_).parent_path(), ignored);  // only if it is empty
}

Bytes HistoryLog::Read(int64_t offset) {
  if (files_ == nullptr || files_->reader == nullptr) return nullptr;
  lcm_eventlog_t* reader = files_->reader.get();
  if (fseeko(reader->f, offset, SEEK_SET) != 0 || fgetc(reader->f) != kFirstByte) return nullptr;
  if (fseeko(reader->f, offset, SEEK_SET) != 0) return nullptr;
  lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(reader);
  if (event == nullptr) return nullptr;
  const auto* data = static_cast<const uint8_t*>(event->data);
  auto message = std::make_shared<const std::vector<uint8_t>>(data, data + event->datalen);
  lcm_eventlog_free_event(event);
  return message;
}

void HistoryLog::Release(int64_t offset) {
  if (files_ == nullptr || files_->writer == nullptr || offset < released_ + kRelease) return;
  const int file = fileno(files_->writer->f);
  fallocate(file, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, released_, offset - released_);
  released_ = offset;
}

}  // namespace plslam::bus
