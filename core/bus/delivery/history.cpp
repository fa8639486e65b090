// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/delivery/history.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <utility>

#include <lcm/eventlog.h>

#include "core/bus/transport/wall_clock.h"

namespace plslam::bus {
namespace {

using LogHandle = std::unique_ptr<lcm_eventlog_t, void (*)(lcm_eventlog_t*)>;

LogHandle OpenLog(const std::string& path, const char* mode) {
  return LogHandle(lcm_eventlog_create(path.c_str(), mode), &lcm_eventlog_destroy);
}

}  // namespace

std::string TemporaryRoot() {
  const char* root = std::getenv("TMPDIR");
  return root != nullptr && *root != '\0' ? root : "/tmp";
}

std::string TemporaryFolder(int64_t source) { return TemporaryRoot() + "/plslam-" + std::to_string(source); }

struct History::Log {
  LogHandle writer;
  LogHandle reader;
  bool dirty = false;
};

History::History(Retention retention, int64_t memory_bytes, std::string channel, std::string path, bool keep_file)
    : retention_(retention),
      memory_limit_(memory_bytes),
      channel_(std::move(channel)),
      path_(std::move(path)),
      keep_file_(keep_file) {}

History::~History() = default;

void History::Append(Bytes message) {
  bytes_ += static_cast<int64_t>(message->size());
  memory_.push_back(std::move(message));
  const int64_t limit = retention_ == Retention::kNone ? 0 : memory_limit_;
  while (bytes_ > limit && memory_.size() > 1) DropOldest();
}

void History::DropOldest() {
  const Bytes oldest = memory_.front();
  memory_.pop_front();
  bytes_ -= static_cast<int64_t>(oldest->size());
  ++memory_first_;
  if (retention_ != Retention::kAll || !Spill(oldest)) first_seq_ = memory_first_;
}

/// False where the disk does not take it (full, gone): the history then begins later, which announcements say.
bool History::Spill(const Bytes& message) {
  if (log_failed_) return false;
  if (log_ == nullptr) {
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(path_).parent_path(), ignored);
    log_ = std::make_unique<Log>(Log{OpenLog(path_, "w"), OpenLog(path_, "r")});
    if (!keep_file_) RemoveFile();
  }
  lcm_eventlog_t* writer = log_->writer.get();
  const int64_t offset = writer != nullptr ? ftello(writer->f) : -1;
  lcm_eventlog_event_t event{};
  event.timestamp = WallClock_us();
  event.channellen = static_cast<int32_t>(channel_.size());
  event.channel = channel_.data();
  event.datalen = static_cast<int32_t>(message->size());
  event.data = const_cast<uint8_t*>(message->data());  // LCM's C interface is not const-correct
  log_failed_ = offset < 0 || log_->reader == nullptr || lcm_eventlog_write_event(writer, &event) != 0;
  if (log_failed_) {
    offsets_.clear();
    return false;
  }
  log_->dirty = true;
  offsets_.push_back(offset);
  return true;
}

/// What is open stays readable without its name, and goes with the process however that ends.
void History::RemoveFile() const {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
  std::filesystem::remove(std::filesystem::path(path_).parent_path(), ignored);  // where nothing else is in it
}

Bytes History::Get(int64_t seq) {
  if (seq < first_seq_ || seq >= next_seq()) return nullptr;
  if (seq >= memory_first_) return memory_[static_cast<size_t>(seq - memory_first_)];
  return ReadSpilled(seq);
}

Bytes History::ReadSpilled(int64_t seq) {
  if (static_cast<size_t>(seq) >= offsets_.size()) return nullptr;
  if (std::exchange(log_->dirty, false)) fflush(log_->writer->f);
  lcm_eventlog_t* reader = log_->reader.get();
  if (fseeko(reader->f, offsets_[static_cast<size_t>(seq)], SEEK_SET) != 0) return nullptr;
  lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(reader);
  if (event == nullptr) return nullptr;
  const auto* data = static_cast<const uint8_t*>(event->data);
  auto message = std::make_shared<const std::vector<uint8_t>>(data, data + event->datalen);
  lcm_eventlog_free_event(event);
  return message;
}

void History::Forget(int64_t seq) {
  if (retention_ == Retention::kAll) return;
  while (memory_first_ < seq && !memory_.empty()) DropOldest();
}

}  // namespace plslam::bus
