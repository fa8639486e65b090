// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "core/datasets/recordings/chunks.h"
#include "core/datasets/recordings/recording.h"

namespace plslam {

/// The index of a recording that has none of its own, or none that can be used: its records are read once, one after
/// the other, up to the end or to the first one that is not whole.
class ScannedIndex {
 public:
  /// What a format says of its records.
  struct Records {
    /// Where the record ends that begins at this byte.
    std::function<uint64_t(uint64_t at)> end;
    /// Reads it, and adds its messages here. False at the record that ends the messages. Where it throws
    /// DatasetError, the record (a chunk, say) is damaged and passed over.
    std::function<bool(uint64_t at, uint64_t end)> take;
  };

  /// `why` the file has to be read, and the `repair` that spares it, for the note.
  void Scan(const RecordingFile& file, uint64_t from, const Records& records, const std::string& why,
            const char* repair);

  /// Fails where there are more messages than bytes of the file, which only a damaged one has.
  void Add(uint32_t channel, const RecordedMessage& message);

  bool is_made() const { return is_made_; }
  /// 0 where nothing was scanned.
  double taken_s() const { return taken_s_; }
  /// In order of time.
  std::vector<RecordedMessage> Messages(const std::string& topic, const std::vector<RecordedChannel>& channels) const;
  /// One sentence; none where nothing was scanned.
  std::vector<std::string> Notes() const;

 private:
  bool is_made_ = false;
  double taken_s_ = 0.0;
  uint64_t messages_left_ = 0;
  std::map<uint32_t, std::vector<RecordedMessage>> messages_;
  std::string note_;
};

}  // namespace plslam
