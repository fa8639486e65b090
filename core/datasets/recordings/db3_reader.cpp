// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/db3_reader.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/recordings/chunks.h"
#include "core/errors/error_text.h"

namespace plslam {
namespace {

constexpr std::string_view kMagic{"SQLite format 3\0", 16};
constexpr const char* kRepair = "`sqlite3 FILE .recover | sqlite3 REPAIRED.db3` repairs what can be";

/// The path as SQLite reads it in a URI.
std::string Escaped(const std::string& path) {
  std::string escaped;
  for (const char c : path) {
    const bool is_special = c == '%' || c == '?' || c == '#';
    escaped += is_special ? fmt::format("%{:02x}", static_cast<unsigned char>(c)) : std::string(1, c);
  }
  return escaped;
}

bool HasContent(const std::string& path) {
  std::error_code missing;
  const auto n = std::filesystem::file_size(path, missing);
  return !missing && n > 0;
}

std::string TextOf(sqlite3_stmt* row, int column) {
  const auto* const text = reinterpret_cast<const char*>(sqlite3_column_text(row, column));
  return text == nullptr ? "" : std::string(text, static_cast<size_t>(sqlite3_column_bytes(row, column)));
}

/// The file's length according to its head: bytes of a page, times pages. 0 if the head has none.
uint64_t BytesOfHead(std::span<const uint8_t> head) {
  constexpr size_t kPageSizeAt = 16, kPagesAt = 28, kHeadBytes = 32;
  if (head.size() < kHeadBytes) return 0;
  const uint64_t page_size = static_cast<uint64_t>(head[kPageSizeAt]) << 8 | head[kPageSizeAt + 1];
  uint64_t n_pages = 0;
  for (size_t i = kPagesAt; i < kHeadBytes; ++i) n_pages = n_pages << 8 | head[i];
  return n_pages * (page_size == 1 ? 1 << 16 : page_size);
}

}  // namespace

Db3Reader::Db3Reader(const std::string& path) {
  const RecordingFile file(path);
  constexpr uint64_t kHeadBytes = 100;
  const std::vector<uint8_t> head = file.ReadAt(0, std::min(file.size(), kHeadBytes), "the head");
  const std::string_view text(reinterpret_cast<const char*>(head.data()), head.size());
  if (text.empty()) throw DatasetError("is empty (0 bytes), not a ROS 2 bag: record it again");
  if (!text.starts_with(kMagic)) {
    throw DatasetError(
        fmt::format("is not a .db3 file of ROS 2, because it begins with '{}': give a file written by `ros2 bag "
                    "record`, or its format (--kind)",
                    Shown(text.substr(0, kMagic.size()))));
  }
  Open(path);
  CheckTables();
  ReadTopics();
  const uint64_t wal_bytes = HasContent(path + "-wal") ? std::filesystem::file_size(path + "-wal") : 0;
  most_bytes_ = file.size() + wal_bytes;
  std::string why = ReadIndex();
  if (why.empty() && wal_bytes == 0 && BytesOfHead(head) > file.size()) {
    why = fmt::format("is truncated ({} of {} bytes)", file.size(), BytesOfHead(head));
  }
  if (why.empty()) return;
  EraseUnreadable();
  size_t n = 0;
  for (const auto& [id, messages] : messages_) n += messages.size();
  notes_.Warn(fmt::format("{}: only the messages that can be read are played ({}); {}", why, n, kRepair));
}

void Db3Reader::Open(const std::string& path) {
  // A database without a log of changes is opened as one that cannot change: neither locks nor further files.
  const bool has_log = HasContent(path + "-wal") || HasContent(path + "-journal");
  const std::string uri = "file:" + Escaped(path) + (has_log ? "?mode=ro" : "?immutable=1");
  sqlite3* opened = nullptr;
  const int flags = SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX;
  const int result = sqlite3_open_v2(uri.c_str(), &opened, flags, nullptr);
  database_.reset(opened);
  if (result != SQLITE_OK) Fail(result);
  // Nothing that the file defines is executed. A truncated file is read as far as it goes.
  sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_ENABLE_TRIGGER, 0, nullptr);
  sqlite3_db_config(opened, SQLITE_DBCONFIG_WRITABLE_SCHEMA, 1, nullptr);
  sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxChunkBytes));
}

void Db3Reader::Fail(int result) const {
  const char* const reason = database_ ? sqlite3_errmsg(database_.get()) : sqlite3_errstr(result);
  throw DatasetError(
      fmt::format("cannot be read as a .db3 file of ROS 2: SQLite reports '{}'; {}", Shown(reason), kRepair));
}

Db3Reader::Statement Db3Reader::Prepare(const char* sql) const {
  sqlite3_stmt* prepared = nullptr;
  const int result = sqlite3_prepare_v2(database_.get(), sql, -1, &prepared, nullptr);
  if (result != SQLITE_OK) Fail(result);
  return Statement(prepared);
}

void Db3Reader::CheckTables() const {
  const Statement tables = Prepare(
      "SELECT count(*) FROM sqlite_master WHERE type='table' AND rootpage>0 AND name IN ('topics','messages')");
  const int result = sqlite3_step(tables.get());
  if (result != SQLITE_ROW) Fail(result);
  if (sqlite3_column_int(tables.get(), 0) == 2) return;
  throw DatasetError(
      "is an SQLite file without the tables 'topics' and 'messages': give one written by `ros2 bag "
      "record`");
}

void Db3Reader::ReadTopics() {
  constexpr size_t kMostTopics = 100'000;
  const Statement topics = Prepare("SELECT id, name, type, serialization_format FROM topics");
  int result = SQLITE_ROW;
  while ((result = sqlite3_step(topics.get())) == SQLITE_ROW && channels_.size() < kMostTopics) {
    const int64_t id = sqlite3_column_int64(topics.get(), 0);
    if (id < 0 || id > std::numeric_limits<uint32_t>::max()) continue;  // no message can be of it
    channels_.push_back({static_cast<uint32_t>(id), TextOf(topics.get(), 1), RosTypeName(TextOf(topics.get(), 2)),
                         TextOf(topics.get(), 3)});
  }
  if (result != SQLITE_DONE) Fail(result);
  const auto by_id = [](const RecordedChannel& a, const RecordedChannel& b) { return a.id < b.id; };
  std::stable_sort(channels_.begin(), channels_.end(), by_id);
}

std::string Db3Reader::ReadIndex() {
  const Statement rows = Prepare("SELECT rowid, topic_id, timestamp FROM messages ORDER BY rowid");
  int64_t last = -1;
  int result = SQLITE_ROW;
  for (uint64_t n = 0; (result = sqlite3_step(rows.get())) == SQLITE_ROW; ++n) {
    const int64_t id = sqlite3_column_int64(rows.get(), 0), topic = sqlite3_column_int64(rows.get(), 1);
    // A damaged tree may name the same page many times.
    if (id <= last || n > most_bytes_) return fmt::format("is damaged after message {}", last);
    last = id;
    if (topic < 0 || topic > std::numeric_limits<uint32_t>::max()) continue;
    const int64_t t_ns = LogTime(static_cast<uint64_t>(sqlite3_column_int64(rows.get(), 2)));
    messages_[static_cast<uint32_t>(topic)].push_back(
        {t_ns, RecordedMessage::kNotRead, RecordedMessage::kNoChunk, static_cast<uint64_t>(id)});
  }
  if (result == SQLITE_DONE) return "";
  return fmt::format("is damaged after message {} (SQLite reports '{}')", last,
                     Shown(sqlite3_errmsg(database_.get())));
}

void Db3Reader::EraseUnreadable() {
  const auto is_unreadable = [&](const RecordedMessage& message) {
    try {
      Read(message);
      return false;
    } catch (const std::runtime_error&) {
      return true;
    }
  };
  for (auto& [id, messages] : messages_) std::erase_if(messages, is_unreadable);
}

std::vector<RecordedMessage> Db3Reader::Messages(const std::string& topic) const {
  std::vector<RecordedMessage> messages;
  for (const RecordedChannel& channel : channels_) {
    const auto found = messages_.find(channel.id);
    if (channel.topic != topic || found == messages_.end()) continue;
    messages.insert(messages.end(), found->second.begin(), found->second.end());
  }
  SortByPlace(messages);
  return messages;
}

sqlite3_blob* Db3Reader::ContentOf(int64_t id) const {
  int result = SQLITE_OK;
  if (blob_) {
    result = sqlite3_blob_reopen(blob_.get(), id);
  } else {
    sqlite3_blob* opened = nullptr;
    result = sqlite3_blob_open(database_.get(), "main", "messages", "data", id, 0, &opened);
    blob_.reset(opened);
  }
  if (result == SQLITE_OK) return blob_.get();
  const std::string reason = Shown(sqlite3_errmsg(database_.get()));
  blob_.reset();  // a blob that could not be moved cannot be used again
  throw DatasetError(fmt::format("message {} cannot be read: SQLite reports '{}'", id, reason));
}

std::vector<uint8_t> Db3Reader::ReadBegin(const RecordedMessage& message, uint64_t n) const {
  const std::scoped_lock lock(mutex_);
  const auto id = static_cast<int64_t>(message.offset);
  sqlite3_blob* const content = ContentOf(id);
  const auto n_content = static_cast<uint64_t>(sqlite3_blob_bytes(content));
  CheckChunkSize(n_content);
  if (n_content > most_bytes_)
    throw DatasetError(fmt::format("message {} is longer than the file: it is damaged", id));
  const uint64_t n_read = std::min(n, n_content);
  auto bytes =
      WithMemoryFor(fmt::format("message {} of {} bytes", id, n_read), [&] { return std::vector<uint8_t>(n_read); });
  const int result = sqlite3_blob_read(content, bytes.data(), static_cast<int>(n_read), 0);
  if (result == SQLITE_OK) return bytes;
  blob_.reset();
  throw DatasetError(fmt::format("message {} cannot be read: SQLite reports '{}'", id, sqlite3_errstr(result)));
}

std::vector<uint8_t> Db3Reader::Read(const RecordedMessage& message) const {
  return ReadBegin(message, std::numeric_limits<uint64_t>::max());
}

bool LooksLikeDb3File(const std::string& path) { return BeginsWith(path, kMagic); }

}  // namespace plslam
