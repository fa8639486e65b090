// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/datasets/recordings/recording.h"

namespace plslam {

/// A .db3 file of ROS 2: an SQLite database with the tables `topics` (id, name, type, serialization_format) and
/// `messages` (id, topic_id, timestamp, data). The offset of a message is its id, and it is in no chunk.
///
/// Messages that were written before the recorder was killed are played also from a write-ahead log (FILE-wal). The
/// readable messages of a damaged or truncated file are played; `Notes` reports this. The file is not changed.
class Db3Reader : public Recording {
 public:
  explicit Db3Reader(const std::string& path);

  const std::vector<RecordedChannel>& channels() const override { return channels_; }
  std::vector<RecordedMessage> Messages(const std::string& topic) const override;
  plslam::Notes Notes() const override { return notes_; }
  double scan_s() const override { return 0.0; }
  std::vector<uint8_t> Read(const RecordedMessage& message) const override;
  std::vector<uint8_t> ReadBegin(const RecordedMessage& message, uint64_t n) const override;
  void WillReadBegin(const RecordedMessage&, uint64_t) const override {}
  uint64_t DecompressionCost(uint32_t) const override { return 0; }

 private:
  template <auto close>
  struct Closer {
    template <class T>
    void operator()(T* closed) const {
      close(closed);
    }
  };
  using Database = std::unique_ptr<sqlite3, Closer<sqlite3_close_v2>>;
  using Statement = std::unique_ptr<sqlite3_stmt, Closer<sqlite3_finalize>>;
  using Blob = std::unique_ptr<sqlite3_blob, Closer<sqlite3_blob_close>>;

  void Open(const std::string& path);
  Statement Prepare(const char* sql) const;
  /// Throws DatasetError with the reason of SQLite.
  [[noreturn]] void Fail(int result) const;
  void CheckTables() const;
  void ReadTopics();
  /// Returns the reason why the rest could not be read; empty if all were.
  std::string ReadIndex();
  /// Removes messages whose content is not in the file.
  void EraseUnreadable();
  /// The content of a message, in pieces; the next call moves it to another message.
  sqlite3_blob* ContentOf(int64_t id) const;

  mutable std::mutex mutex_;
  Database database_;
  mutable Blob blob_;
  std::vector<RecordedChannel> channels_;
  std::map<uint32_t, std::vector<RecordedMessage>> messages_;  ///< by channel
  uint64_t most_bytes_ = 0;  ///< of a message, and the most messages: those of the file
  plslam::Notes notes_;
};

/// The file begins as SQLite databases do.
bool LooksLikeDb3File(const std::string& path);

}  // namespace plslam
