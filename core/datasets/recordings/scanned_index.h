// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/datasets/recordings/chunks.h"
#include "core/datasets/recordings/recording.h"
#include "core/files/notes.h"

namespace plslam {

/// The index of a recording that has none, or no usable one: its records are read once, one after the other, up to the
/// end or to the first incomplete one.
class ScannedIndex {
 public:
  /// The record structure of a format.
  struct Records {
    /// Returns the end of the record that begins at this byte.
    std::function<uint64_t(uint64_t at)> end;
    /// Reads the record, and adds its messages to this index. Returns false at the record that ends the messages. If it
    /// throws DatasetError, the record (a chunk, for example) is damaged and skipped.
    std::function<bool(uint64_t at, uint64_t end)> take;
  };

  /// A reason that begins so is none of damage: recorders may write no index, or none of a kind.
  static constexpr std::string_view kNoIndex = "has no index";
  /// `why` the file must be scanned, and the `repair` that avoids it, are quoted in the note.
  void Scan(const RecordingFile& file, uint64_t from, const Records& records, const std::string& why,
            const char* repair);

  void Add(uint32_t channel, const RecordedMessage& message);
  /// Bytes that are kept of names, and those of a chunk that is about to be decompressed. They fail, as `Add` does, at
  /// a size that only a damaged file can have, and the scan ends there.
  void SpendKept(uint64_t bytes) { Spend(kept_left_, bytes, "messages and names"); }
  void SpendDecompressed(uint64_t bytes) { Spend(decompressed_left_, bytes, "bytes in its chunks"); }

  bool is_made() const { return is_made_; }
  /// Duration of the scan; 0 if nothing was scanned.
  double taken_s() const { return taken_s_; }
  bool has_messages() const { return !messages_.empty(); }
  /// Returns the messages in the order of the file.
  std::vector<RecordedMessage> Messages(const std::string& topic, const std::vector<RecordedChannel>& channels) const;
  /// One sentence, a remark if the file is complete, else a warning; empty if nothing was scanned.
  plslam::Notes Notes() const;

 private:
  struct Findings;
  Findings ReadRecords(const RecordingFile& file, uint64_t from, const Records& records);
  void Spend(uint64_t& left, uint64_t n, const char* what);

  bool is_made_ = false;
  bool is_damaged_ = false;  ///< or cut off
  double taken_s_ = 0.0;
  uint64_t kept_left_ = 0, decompressed_left_ = 0;
  bool is_spent_ = false;
  std::map<uint32_t, std::vector<RecordedMessage>> messages_;
  std::string note_;
};

}  // namespace plslam
