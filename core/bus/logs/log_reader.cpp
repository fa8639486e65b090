// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/logs/log_reader.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <stdexcept>

#include <fcntl.h>
#include <lcm/lcm.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/bus/transport/wire.h"
#include "core/errors/error_text.h"

namespace plslam::bus {
namespace {

/// An event: sync word, number (8 bytes), time (8), length of the channel name (4), of the data (4), name, data.
constexpr uint32_t kSync = 0xEDA1DA01;
constexpr int64_t kPreambleBytes = 28;

uint32_t Word(const uint8_t* p) { return static_cast<uint32_t>(ReadInt32(p)); }

}  // namespace

LogReader::LogReader(const std::string& path) : fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (fd_ < 0 || fstat(fd_, &status) != 0 || !S_ISREG(status.st_mode)) {
    const std::string why = fd_ < 0 ? ReasonOf(errno) : "not a regular file";
    if (fd_ >= 0) close(fd_);
    throw std::runtime_error(path + ": cannot be read: " + why);
  }
  size_ = status.st_size;
}

LogReader::~LogReader() { close(fd_); }

bool LogReader::ReadAt(int64_t offset, uint8_t* out, size_t bytes) const {
  while (bytes > 0) {
    const ssize_t n = pread(fd_, out, bytes, offset);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    offset += n;
    out += n;
    bytes -= static_cast<size_t>(n);
  }
  return true;
}

/// Moves to the next sync word from `position_` on.
bool LogReader::FindSync() {
  std::array<uint8_t, 65'536> block{};
  while (position_ + kPreambleBytes <= size_) {
    const auto n = static_cast<size_t>(std::min<int64_t>(block.size(), size_ - position_));
    if (!ReadAt(position_, block.data(), n)) return false;
    for (size_t i = 0; i + 4 <= n; ++i) {
      if (Word(&block[i]) != kSync) continue;
      position_ += static_cast<int64_t>(i);
      skipped_bytes_ += static_cast<int64_t>(i);
      return true;
    }
    position_ += static_cast<int64_t>(n) - 3;
    skipped_bytes_ += static_cast<int64_t>(n) - 3;
  }
  return false;
}

std::optional<LogReader::Event> LogReader::Next() {
  static constexpr size_t kWindow = kPreambleBytes + LCM_MAX_CHANNEL_NAME_LENGTH + kHeadBytes;
  std::array<uint8_t, kWindow> window{};
  while (position_ + kPreambleBytes <= size_) {
    const auto there = static_cast<size_t>(std::min<int64_t>(kWindow, size_ - position_));
    if (!ReadAt(position_, window.data(), there)) return std::nullopt;
    const int32_t name_bytes = ReadInt32(&window[20]);
    const int32_t data_bytes = ReadInt32(&window[24]);
    const int64_t data_offset = position_ + kPreambleBytes + name_bytes;
    const bool ok = Word(window.data()) == kSync && name_bytes > 0 && name_bytes <= LCM_MAX_CHANNEL_NAME_LENGTH &&
                    data_bytes >= 0 && data_offset + data_bytes <= size_;
    if (!ok) {
      ++position_;
      ++skipped_bytes_;
      if (!FindSync()) return std::nullopt;
      continue;
    }
    Event event;
    event.timestamp_us = ReadInt64(&window[12]);
    event.channel.assign(reinterpret_cast<const char*>(&window[kPreambleBytes]), static_cast<size_t>(name_bytes));
    event.data_offset = data_offset;
    event.data_bytes = data_bytes;
    const auto head = window.begin() + kPreambleBytes + name_bytes;
    event.head.assign(head, head + std::min<int64_t>(data_bytes, kHeadBytes));
    position_ = data_offset + data_bytes;
    return event;
  }
  return std::nullopt;
}

std::optional<std::vector<uint8_t>> LogReader::Data(int64_t offset, int64_t bytes) const {
  if (offset < 0 || bytes < 0 || offset + bytes > size_) return std::nullopt;
  std::vector<uint8_t> data(static_cast<size_t>(bytes));
  if (!ReadAt(offset, data.data(), data.size())) return std::nullopt;
  return data;
}

bool LooksLikeLcmLog(const std::string& path) {
  try {
    return LogReader(path).Next().has_value();
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace plslam::bus
