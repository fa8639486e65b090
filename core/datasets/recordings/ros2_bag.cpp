// SPDX-License-Identifier: BSD-3-Clause
#include "core/datasets/recordings/ros2_bag.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "core/datasets/recordings/db3_reader.h"
#include "core/datasets/recordings/mcap_reader.h"
#include "core/errors/error_text.h"

namespace plslam {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMetadata = "metadata.yaml";
constexpr const char* kMetadataRoot = "rosbag2_bagfile_information";
constexpr std::string_view kZstd = ".zstd";
constexpr auto kExtensions = std::to_array<std::string_view>({".db3", ".mcap", ".db3.zstd", ".mcap.zstd"});

// A message is found by its file and its chunk there: both are in the chunk that callers see.
constexpr uint32_t kChunkBits = 20;
constexpr uint32_t kOutsideChunks = (1U << kChunkBits) - 1;
constexpr size_t kMostFiles = (1U << (32 - kChunkBits)) - 1;  // the last one would have `kNoChunk`

uint32_t ChunkInFile(uint32_t chunk) {
  const uint32_t inner = chunk & kOutsideChunks;
  return inner == kOutsideChunks ? RecordedMessage::kNoChunk : inner;
}

RecordedMessage InFile(RecordedMessage message) {
  message.chunk = ChunkInFile(message.chunk);
  return message;
}

bool IsBagFile(const std::string& name) {
  return std::any_of(kExtensions.begin(), kExtensions.end(),
                     [&](std::string_view extension) { return name.ends_with(extension); });
}

/// "walk_10.db3" comes after "walk_9.db3".
std::pair<uint64_t, std::string> OrderOf(const std::string& name) {
  constexpr const char* kDigits = "0123456789";
  constexpr size_t kMostDigits = 18;
  const size_t last = name.find_last_of(kDigits, name.find('.'));
  if (last == std::string::npos) return {0, name};
  size_t first = name.find_last_not_of(kDigits, last);
  first = first == std::string::npos ? 0 : first + 1;
  return {std::stoull(name.substr(first, std::min(last + 1 - first, kMostDigits))), name};
}

/// The files of a folder in their order by name.
std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && IsBagFile(name)) names.push_back(name);
  }
  // A compressed file beside its content is left from `ros2 bag play`.
  std::erase_if(names, [&](const std::string& name) {
    return name.ends_with(kZstd) &&
           std::find(names.begin(), names.end(), name.substr(0, name.size() - kZstd.size())) != names.end();
  });
  std::sort(names.begin(), names.end(),
            [](const std::string& a, const std::string& b) { return OrderOf(a) < OrderOf(b); });
  return names;
}

/// Returns the names of files in metadata.yaml; empty without one, or if it is damaged, as `notes` then states.
std::vector<std::string> FilesOfMetadata(const std::string& folder, Notes* notes) {
  const fs::path path = fs::path(folder) / kMetadata;
  std::vector<std::string> names;
  if (!fs::exists(path)) return names;
  try {
    const YAML::Node root = YAML::LoadFile(path.string())[kMetadataRoot];
    for (const auto& name : root["relative_file_paths"]) {
      // Bags of before 2020 have the name of the folder in front.
      names.push_back(fs::path(name.as<std::string>()).filename().string());
    }
  } catch (const YAML::Exception& error) {
    notes->Warn(fmt::format("{} cannot be read ({}), and files are played in the order of their names", kMetadata,
                            Shown(error.what())));
    names.clear();
  }
  return names;
}

/// Returns the files to play, in their order.
std::vector<std::string> FilesOf(const std::string& folder, Notes* notes) {
  std::vector<std::string> files = FilesIn(folder), chosen;
  for (const std::string& name : FilesOfMetadata(folder, notes)) {
    const auto fits = [&](const std::string& file) { return file == name || file + std::string(kZstd) == name; };
    const auto found = std::find_if(files.begin(), files.end(), fits);
    if (found != files.end()) {
      chosen.push_back(*found);
      files.erase(found);
    } else if (std::find(chosen.begin(), chosen.end(), name) == chosen.end()) {
      notes->Warn(
          fmt::format("{} names the file {}, which is missing: its messages are not played", kMetadata, Shown(name)));
    }
  }
  if (!chosen.empty() && !files.empty()) {
    notes->Remark(fmt::format("{} files that {} does not name are played after the others, {} first", files.size(),
                              kMetadata, files.front()));
  }
  chosen.insert(chosen.end(), files.begin(), files.end());
  if (chosen.empty()) {
    throw DatasetError("has no .db3 or .mcap files: copy them beside metadata.yaml");
  }
  if (chosen.size() > kMostFiles) {
    throw DatasetError(fmt::format("has {} files, more than {}", chosen.size(), kMostFiles));
  }
  return chosen;
}

/// Errors get the name of the file in front where it is one of several.
template <class F>
auto Named(const std::string& name, F f) {
  try {
    return f();
  } catch (const DatasetError& error) {
    if (name.empty()) throw;
    throw DatasetError(fmt::format("{}: {}", name, error.what()));
  }
}

}  // namespace

Ros2Bag::Ros2Bag(const std::string& path, const std::string& why_scan) {
  if (!fs::is_directory(path)) {
    Open(path, "", why_scan);
  } else {
    for (const std::string& name : FilesOf(path, &notes_)) Open((fs::path(path) / name).string(), name, why_scan);
  }
  std::map<std::string, RecordedChannel> by_topic;
  for (const Part& part : parts_) {
    for (const RecordedChannel& channel : part.reader->channels()) by_topic.emplace(channel.topic, channel);
  }
  for (auto& [topic, channel] : by_topic) {
    channel.id = static_cast<uint32_t>(channels_.size());
    channels_.push_back(std::move(channel));
  }
}

void Ros2Bag::Open(const std::string& path, const std::string& name, const std::string& why_scan) {
  Named(name, [&] {
    Part part{name, nullptr, nullptr};
    std::string file = path;
    if (path.ends_with(kZstd)) {
      part.unpacked = std::make_unique<UnzstdFile>(path);
      file = part.unpacked->path();
    }
    if (path.find(".mcap", path.rfind('/') + 1) != std::string::npos) {
      part.reader = std::make_unique<McapReader>(file, why_scan);
    } else {
      part.reader = std::make_unique<Db3Reader>(file);
    }
    const auto named = [&](const std::string& note) { return name.empty() ? note : name + ": " + note; };
    const plslam::Notes notes = part.reader->Notes();
    for (const std::string& warning : notes.warnings) notes_.Warn(named(warning));
    for (const std::string& remark : notes.remarks) notes_.Remark(named(remark));
    parts_.push_back(std::move(part));
  });
}

const Ros2Bag::Part& Ros2Bag::PartOf(uint32_t chunk) const { return parts_.at(chunk >> kChunkBits); }

std::vector<RecordedMessage> Ros2Bag::Messages(const std::string& topic) const {
  std::vector<RecordedMessage> all;
  for (size_t i = 0; i < parts_.size(); ++i) {
    std::vector<RecordedMessage> messages = Named(parts_[i].name, [&] { return parts_[i].reader->Messages(topic); });
    for (RecordedMessage& message : messages) {
      const bool is_outside = message.chunk == RecordedMessage::kNoChunk;
      if (!is_outside && message.chunk >= kOutsideChunks) {
        throw DatasetError(fmt::format("has more than {} chunks in one file", kOutsideChunks));
      }
      message.chunk = static_cast<uint32_t>(i) << kChunkBits | (is_outside ? kOutsideChunks : message.chunk);
    }
    // A scan took the begin of compressed messages for their stamps.
    const bool has_stamps = !messages.empty() && messages.front().stamp_ns != RecordedMessage::kNotRead;
    if (has_stamps && IsZstd(parts_[i].reader->ReadBegin(InFile(messages.front()), kStampBytes))) {
      for (RecordedMessage& message : messages) message.stamp_ns = RecordedMessage::kNotRead;
    }
    all.insert(all.end(), messages.begin(), messages.end());
  }
  return all;
}

double Ros2Bag::scan_s() const {
  double sum_s = 0.0;
  for (const Part& part : parts_) sum_s += part.reader->scan_s();
  return sum_s;
}

std::vector<uint8_t> Ros2Bag::Read(const RecordedMessage& message) const {
  const Part& part = PartOf(message.chunk);
  return Named(part.name, [&] {
    std::vector<uint8_t> bytes = part.reader->Read(InFile(message));
    return IsZstd(bytes) ? UnzstdMessage(bytes) : bytes;
  });
}

std::vector<uint8_t> Ros2Bag::ReadBegin(const RecordedMessage& message, uint64_t n) const {
  const Part& part = PartOf(message.chunk);
  std::vector<uint8_t> begin =
      Named(part.name, [&] { return part.reader->ReadBegin(InFile(message), std::max(n, kStampBytes)); });
  if (IsZstd(begin)) begin = Read(message);
  begin.resize(std::min<uint64_t>(begin.size(), n));
  return begin;
}

void Ros2Bag::WillReadBegin(const RecordedMessage& message, uint64_t n) const {
  PartOf(message.chunk).reader->WillReadBegin(InFile(message), std::max(n, kStampBytes));
}

uint64_t Ros2Bag::DecompressionCost(uint32_t chunk) const {
  const uint32_t inner = ChunkInFile(chunk);
  return inner == RecordedMessage::kNoChunk ? 0 : PartOf(chunk).reader->DecompressionCost(inner);
}

bool LooksLikeRos2BagPath(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) {
    return LooksLikeDb3File(path) ||
           (fs::is_regular_file(path, error) && (path.ends_with(".db3") || path.ends_with(".db3.zstd")));
  }
  size_t n_bag_files = 0, n_others = 0;
  for (const auto& entry : fs::directory_iterator(path, error)) {
    const std::string name = entry.path().filename().string();
    if (name.find(".db3") != std::string::npos) return true;
    ++(IsBagFile(name) ? n_bag_files : n_others);
  }
  try {
    const std::string metadata = (fs::path(path) / kMetadata).string();
    if (fs::exists(metadata, error)) return YAML::LoadFile(metadata)[kMetadataRoot].IsDefined();
  } catch (const YAML::Exception&) {
    return n_bag_files > 0;
  }
  return n_bag_files > 0 && n_others == 0;
}

}  // namespace plslam
