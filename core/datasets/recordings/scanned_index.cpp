// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/scanned_index.h"

#include <chrono>

#include <fmt/format.h>

namespace plslam {
namespace {

/// Messages and bytes of names that a small file may have beyond one for each of its bytes.
constexpr uint64_t kLeastKept = 1 << 20;
/// A channel that has messages takes as much memory as so many bytes of names.
constexpr uint64_t kChannelBytes = 100;

std::string Megabytes(uint64_t bytes) { return fmt::format("{:.1f} MB", static_cast<double>(bytes) * 1e-6); }

}  // namespace

/// Findings during the scan of a file.
struct ScannedIndex::Findings {
  uint64_t whole_bytes = 0;    ///< up to here records are complete
  uint64_t missing_bytes = 0;  ///< of the record after them
  int n_damaged = 0;
  std::string first_damage;
};

ScannedIndex::Findings ScannedIndex::ReadRecords(const RecordingFile& file, uint64_t from, const Records& records) {
  Findings found;
  for (found.whole_bytes = from; found.whole_bytes < file.size();) {
    const uint64_t at = found.whole_bytes;
    uint64_t end = 0;
    try {
      end = records.end(at);
    } catch (const DatasetError&) {
      return found;  // not even its head is whole
    }
    if (end > file.size() || end <= at) {
      found.missing_bytes = end - file.size();
      return found;
    }
    found.whole_bytes = end;
    try {
      if (!records.take(at, end)) found.whole_bytes = file.size();
    } catch (const DatasetError& error) {
      if (found.n_damaged++ == 0 || is_spent_) found.first_damage = error.what();
      if (!is_spent_) continue;
      found.whole_bytes = at;
      return found;
    }
  }
  return found;
}

void ScannedIndex::Scan(const RecordingFile& file, uint64_t from, const Records& records, const std::string& why,
                        const char* repair) {
  const auto begin = std::chrono::steady_clock::now();
  kept_left_ = file.size() + kLeastKept;
  decompressed_left_ = kMostCompression * file.size() + kMaxChunkBytes;
  const Findings found = ReadRecords(file, from, records);
  taken_s_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  is_made_ = true;
  is_damaged_ = !why.starts_with(kNoIndex) || found.whole_bytes < file.size() || found.n_damaged > 0;
  note_ = fmt::format(
      "{}: all of its {} were read to find the messages, which took {:.1f} s each time it is opened; {} writes an "
      "index",
      why, Megabytes(file.size()), taken_s_, repair);
  if (found.whole_bytes < file.size()) {
    const uint64_t rest = file.size() - found.whole_bytes;
    note_ += fmt::format("; its last {} bytes are not played because they belong to a record that ", rest);
    const bool is_cut = found.missing_bytes > 0 && found.missing_bytes <= kMaxChunkBytes;
    note_ +=
        is_cut ? fmt::format("is truncated ({} bytes are missing)", found.missing_bytes) : "is truncated or damaged";
  }
  if (found.n_damaged > 0) {
    note_ +=
        fmt::format("; damaged chunks or records skipped: {} (the first: {})", found.n_damaged, found.first_damage);
  }
}

void ScannedIndex::Add(uint32_t channel, const RecordedMessage& message) {
  SpendKept(messages_.contains(channel) ? 1 : kChannelBytes);
  messages_[channel].push_back(message);
}

void ScannedIndex::Spend(uint64_t& left, uint64_t n, const char* what) {
  is_spent_ = n > left;
  if (is_spent_) throw DatasetError(fmt::format("there are more {} than the file can contain: it is damaged", what));
  left -= n;
}

std::vector<RecordedMessage> ScannedIndex::Messages(const std::string& topic,
                                                    const std::vector<RecordedChannel>& channels) const {
  std::vector<RecordedMessage> messages;
  for (const RecordedChannel& channel : channels) {
    const auto found = messages_.find(channel.id);
    if (channel.topic != topic || found == messages_.end()) continue;
    messages.insert(messages.end(), found->second.begin(), found->second.end());
  }
  SortByPlace(messages);
  return messages;
}

plslam::Notes ScannedIndex::Notes() const {
  plslam::Notes notes;
  if (is_made_) notes.Add(is_damaged_, note_);
  return notes;
}

}  // namespace plslam
