// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/db3_file.h"

#include <fmt/format.h>
#include <sqlite3.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

#include "tests/unit/datasets/dataset_folders.h"
#include "tests/unit/datasets/mcap_file.h"

namespace plslam::test {
namespace {

std::string Hex(const std::string& bytes) {
  std::string text;
  for (const char byte : bytes) text += fmt::format("{:02x}", static_cast<uint8_t>(byte));
  return text;
}

}  // namespace

void ExecuteSql(const std::filesystem::path& path, const std::string& sql) {
  sqlite3* database = nullptr;
  char* reason = nullptr;
  int result = sqlite3_open(path.c_str(), &database);
  if (result == SQLITE_OK) result = sqlite3_exec(database, sql.c_str(), nullptr, nullptr, &reason);
  const std::string error = reason == nullptr ? "cannot be opened" : reason;
  sqlite3_free(reason);
  sqlite3_close(database);
  if (result != SQLITE_OK) throw std::runtime_error(path.string() + ": " + error);
}

void MakeDb3File(const std::filesystem::path& path, const RecordingOptions& options, bool zstd_messages, int frame) {
  std::filesystem::create_directories(path.parent_path());
  std::filesystem::remove(path);
  std::string sql =
      "BEGIN; CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);"
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
      "NOT NULL, offered_qos_profiles TEXT NOT NULL);"
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data "
      "BLOB "
      "NOT NULL); CREATE INDEX timestamp_idx ON messages (timestamp ASC);";
  const std::vector<TinyTopic> topics = TinyTopics(options);
  for (size_t id = 0; id < topics.size(); ++id) {
    sql += fmt::format("INSERT INTO topics VALUES({}, '{}', '{}/msg/{}', 'cdr', '');", id + 1, topics[id].topic,
                       topics[id].package, topics[id].type);
  }
  int i = 0;
  for (const std::vector<TinyMessage>& messages : TinyChunks(options, false)) {
    if (frame >= 0 && i++ != frame) continue;
    for (const auto& [channel, log_ns, cdr] : messages) {
      sql += fmt::format("INSERT INTO messages(topic_id, timestamp, data) VALUES({}, {}, x'{}');", channel + 1,
                         log_ns, Hex(zstd_messages ? CompressedChunk(cdr, "zstd") : cdr));
    }
  }
  ExecuteSql(path, sql + "COMMIT;");
}

void MakeDb3FileWithLog(const std::filesystem::path& path) {
  const std::filesystem::path live = path.string() + ".live";
  MakeDb3File(live);
  sqlite3* database = nullptr;
  sqlite3_open(live.c_str(), &database);
  const char* const sql =
      "PRAGMA journal_mode=WAL; PRAGMA wal_autocheckpoint=0; CREATE TABLE late AS SELECT * FROM messages WHERE id > "
      "7;"
      "DELETE FROM messages WHERE id > 7; PRAGMA wal_checkpoint(TRUNCATE); INSERT INTO messages SELECT * FROM late;";
  const bool is_done = sqlite3_exec(database, sql, nullptr, nullptr, nullptr) == SQLITE_OK;
  // Closing the database would move the log into it.
  for (const char* part : {"", "-wal"}) std::filesystem::copy(live.string() + part, path.string() + part);
  sqlite3_close(database);
  if (!is_done) throw std::runtime_error(path.string() + ": cannot be written");
}

void MakeRos2Bag(const std::filesystem::path& folder, const Ros2BagOptions& form, const RecordingOptions& options) {
  std::filesystem::create_directories(folder);
  std::string names;
  for (int i = 0; i < (form.split ? options.n_frames : 1); ++i) {
    std::string name = fmt::format("walk_{}{}", 8 + i, form.extension);
    const std::filesystem::path path = folder / name;
    if (form.extension == ".mcap") {
      MakeMcapFile(path, options);
    } else {
      MakeDb3File(path, options, form.zstd_messages, form.split ? i : -1);
    }
    if (form.zstd_files) {
      name += ".zstd";
      WriteText(folder / name, CompressedChunk(ReadText(path), "zstd"));
      std::filesystem::remove(path);
    }
    names += fmt::format("    - {}\n", name);
  }
  if (!form.metadata) return;
  WriteText(folder / "metadata.yaml",
            fmt::format("rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n  "
                        "relative_file_paths:\n{}  compression_format: {}\n  compression_mode: {}\n",
                        names, form.zstd_files || form.zstd_messages ? "zstd" : "\"\"",
                        form.zstd_files ? "FILE" : (form.zstd_messages ? "MESSAGE" : "\"\"")));
}

}  // namespace plslam::test
