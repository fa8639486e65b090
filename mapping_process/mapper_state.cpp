// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/mapper_state.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "core/errors/error_text.h"
#include "core/files/mapped_file.h"
#include "core/files/sealed_file.h"
#include "core/io/maps/map_records.h"

namespace plslam::archive {

template <class Archive, Is<AdjustmentFigures> T>
void Fields(Archive& a, T& f) {
  a(f.n_keyframes, f.n_fixed_keyframes, f.n_points, f.n_lines, f.n_outliers, f.rms_before, f.rms_after,
    f.reprojection_before_px, f.reprojection_after_px);
}

template <class Archive, Is<LoopAnswer> T>
void Fields(Archive& a, T& answer) {
  a(answer.keyframe, answer.map_version, answer.accepted);
}

/// The scalar fields; keyframes, landmarks and features are written separately.
template <class Archive, Is<mapping::MapperState> T>
void Fields(Archive& a, T& state) {
  a(state.stored, state.stored.sessions, state.recent_landmarks, state.missed_landmarks, state.visits,
    state.inertial_links, state.tracker, state.figures, state.committed, state.structural_version,
    state.localise_only, state.map_id, state.lockstep, state.closures, state.answer);
}

}  // namespace plslam::archive

namespace plslam::mapping {
namespace {

using Bytes = std::span<const uint8_t>;

constexpr FileKind kStateRecord{
    {'P', 'L', 'S', 'L', 'M', 'P', 'S', 'T'}, 11, "state of a mapping_process", Checksum::kPoly1305};

enum class RecordKind : uint8_t { kFeatures, kMap, kChanges };

/// Receives the bytes of a record and its seal.
using Sink = std::function<void(std::string_view)>;

uint64_t WriteRecord(archive::Writer&& write, const Sink& sink) {
  const Bytes content = write.Written();
  const Seal seal = MakeSeal(kStateRecord, content);
  sink({reinterpret_cast<const char*>(&seal), sizeof(seal)});
  sink({reinterpret_cast<const char*>(content.data()), content.size()});
  return sizeof(seal) + content.size();
}

/// Writes the features of keyframes after `newest`, a bounded number in each record.
uint64_t WriteFeatures(const KeyframeFeatures& features, KeyframeId newest, const Sink& sink) {
  constexpr uint64_t kMost = 16;
  uint64_t length = 0;
  auto next = features.upper_bound(newest);
  auto n_left = static_cast<uint64_t>(std::distance(next, features.end()));
  while (n_left > 0) {
    const uint64_t n = std::min(kMost, n_left);
    n_left -= n;
    archive::Writer write;
    write(RecordKind::kFeatures, n);
    std::map<KeyframeId, TakenImage> images;
    for (uint64_t i = 0; i < n; ++i, ++next) {
      write(next->first, static_cast<const FeaturesView&>(next->second));
      if (next->second.image) images[next->first] = *next->second.image;
      next->second.LeaveMemory();
    }
    write(images);
    length += WriteRecord(std::move(write), sink);
  }
  return length;
}

/// Approximate size of the features in the file.
uint64_t LengthOf(const KeyframeFeatures& features) {
  uint64_t length = 0;
  for (const auto& [id, of] : features) length += of.points.size_bytes() + of.lines.size_bytes();
  return length;
}

uint64_t WriteMap(const MapperState& state, const Sink& sink) {
  const Map& map = state.stored.map;
  archive::Writer write;
  write(RecordKind::kMap, state);
  map_file::WriteValues(write, map.keyframes());
  map_file::WriteValues(write, map.points());
  map_file::WriteValues(write, map.lines());
  write(map.loops(), map_file::UpDirectionsOf(map));
  return WriteRecord(std::move(write), sink);
}

/// Removes duplicates from `ids`, and moves ids that are no longer in `values` to `gone`.
template <class AnId, class Value>
void SplitByPresence(const IdMap<AnId, Value>& values, std::vector<AnId>& ids, std::vector<AnId>& gone) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  const auto first_gone =
      std::stable_partition(ids.begin(), ids.end(), [&values](AnId id) { return values.contains(id); });
  gone.assign(first_gone, ids.end());
  ids.erase(first_gone, ids.end());
}

template <class Value>
auto IdsOf(const std::vector<Value>& values) {
  std::vector<decltype(Value::id)> ids;
  ids.reserve(values.size());
  for (const Value& value : values) ids.push_back(value.id);
  return ids;
}

template <class Value>
void AppendTo(std::vector<Value>& values, const std::vector<Value>& more) {
  values.insert(values.end(), more.begin(), more.end());
}

void ReadFeatures(archive::Reader& read, MapperState& state) {
  map_file::ReadFeatures(read, state.stored.features);
  map_file::ReadImages(read, state.stored.features);
}

void ReadMap(archive::Reader& read, MapperState& state) {
  state.stored.map.Clear();
  map_file::ReadKeyframes(read, state.stored);
  const int64_t point_observations = map_file::ReadLandmarks<MapPoint>(read, state.stored);
  const int64_t line_observations = map_file::ReadLandmarks<MapLine>(read, state.stored);
  map_file::CheckObservationsOnce(state.stored.map, point_observations, line_observations);
  map_file::ReadLoops(read, state.stored.map);
  map_file::ReadUpDirections(read, state.stored.map);
}

/// Removes before it inserts, as `MapFollower::Apply` does.
void ReadChanges(archive::Reader& read, MapperState& state) {
  std::vector<KeyframeId> keyframes;
  std::vector<LandmarkId> points, lines;
  read(points, lines, keyframes);
  for (const LandmarkId id : points) state.stored.map.RemovePoint(id);
  for (const LandmarkId id : lines) state.stored.map.RemoveLine(id);
  for (const KeyframeId id : keyframes) state.stored.map.RemoveKeyframe(id);
  map_file::ReadKeyframes(read, state.stored);
  map_file::ReadLandmarks<MapPoint>(read, state.stored);
  map_file::ReadLandmarks<MapLine>(read, state.stored);
  map_file::ReadLoops(read, state.stored.map);
  map_file::ReadUpDirections(read, state.stored.map);
}

/// Applies a record. Returns whether it completes a state; false for features, which belong to the next state.
bool ReadRecord(Bytes content, MapperState& state) {
  archive::Reader read(content);
  RecordKind kind{};
  read(kind);
  if (kind != RecordKind::kFeatures) read(state);
  if (kind == RecordKind::kFeatures) {
    ReadFeatures(read, state);
  } else if (kind == RecordKind::kMap) {
    ReadMap(read, state);
  } else {
    ReadChanges(read, state);
  }
  if (!read.AtEnd()) throw std::runtime_error("the content is longer than stated in its header");
  return kind != RecordKind::kFeatures;
}

void CloseFile(std::FILE* file) { std::fclose(file); }

}  // namespace

std::vector<uint8_t> EncodeState(const MapperState& state) {
  std::vector<uint8_t> bytes;
  const Sink sink = [&](std::string_view record) { bytes.insert(bytes.end(), record.begin(), record.end()); };
  WriteFeatures(state.stored.features, -1, sink);
  WriteMap(state, sink);
  return bytes;
}

MapperState DecodeState(std::span<const uint8_t> bytes) {
  MapperState state;
  bool has_state = false;
  Bytes rest = bytes;
  while (const std::optional<Bytes> content = TakeSealed(kStateRecord, rest)) {
    has_state |= ReadRecord(*content, state);
  }
  if (!has_state) {
    CheckKind(kStateRecord, bytes);
    throw std::runtime_error("is damaged or was truncated before its first state");
  }
  StoredMap& stored = state.stored;
  std::erase_if(stored.features, [&](const auto& entry) { return stored.map.FindKeyframe(entry.first) == nullptr; });
  map_file::CheckWhole(stored);
  stored.map.ForgetChanges();
  return state;
}

MapperState ReadStateFile(const std::string& path) {
  return NamingFile(path, [&] { return DecodeState(MappedFile::Open(path)->bytes()); });
}

void StateFile::Note(const MapUpdate& update) {
  if (!is_whole_) return;
  has_moved_ |= !update.moved_keyframes.empty();
  AppendTo(keyframes_, IdsOf(update.keyframes));
  AppendTo(points_, IdsOf(update.points));
  AppendTo(lines_, IdsOf(update.lines));
  AppendTo(loops_, update.loops);
  AppendTo(keyframes_, update.removed_keyframes);
  AppendTo(points_, update.removed_points);
  AppendTo(lines_, update.removed_lines);
}

void StateFile::ForgetNotes() {
  has_moved_ = false;
  keyframes_.clear();
  points_.clear();
  lines_.clear();
  loops_.clear();
}

void StateFile::Reset() {
  is_whole_ = false;
  ForgetNotes();
}

void StateFile::Write(const MapperState& state) {
  std::error_code error;
  const bool is_there = is_whole_ && std::filesystem::file_size(path_, error) == length_ && !error;
  // Stays false if writing fails half-way: nothing may then be appended.
  is_whole_ = false;
  try {
    if (is_there && length_ <= 2 * (LengthOf(state.stored.features) + map_length_)) {
      Append(state);
    } else {
      WriteWhole(state);
    }
  } catch (...) {
    ForgetNotes();
    throw;
  }
  is_whole_ = true;
  ForgetNotes();
  if (!state.stored.features.empty()) newest_features_ = state.stored.features.rbegin()->first;
}

void StateFile::WriteWhole(const MapperState& state) {
  AtomicFile file(path_);
  const Sink sink = [&](std::string_view record) { file.Append(record); };
  length_ = WriteFeatures(state.stored.features, -1, sink);
  length_ += map_length_ = WriteMap(state, sink);
  file.PutInPlace();
}

void StateFile::Append(const MapperState& state) {
  const std::unique_ptr<std::FILE, void (*)(std::FILE*)> file(std::fopen(path_.c_str(), "ab"), &CloseFile);
  const auto fail = [&] { throw std::runtime_error(path_ + ": cannot be written: " + ReasonOf(errno)); };
  if (file == nullptr) fail();
  const Sink sink = [&](std::string_view record) {
    if (std::fwrite(record.data(), 1, record.size(), file.get()) != record.size()) fail();
    length_ += record.size();
  };
  WriteFeatures(state.stored.features, newest_features_, sink);
  if (has_moved_) {
    map_length_ = WriteMap(state, sink);
  } else {
    const Map& map = state.stored.map;
    std::vector<KeyframeId> keyframes;
    std::vector<LandmarkId> points, lines;
    SplitByPresence(map.keyframes(), keyframes_, keyframes);
    SplitByPresence(map.points(), points_, points);
    SplitByPresence(map.lines(), lines_, lines);
    archive::Writer write;
    write(RecordKind::kChanges, state, points, lines, keyframes);
    map_file::WriteValues(write, map.keyframes(), keyframes_);
    map_file::WriteValues(write, map.points(), points_);
    map_file::WriteValues(write, map.lines(), lines_);
    write(loops_, map_file::UpDirectionsOf(map, keyframes_));
    WriteRecord(std::move(write), sink);
  }
  if (std::fflush(file.get()) != 0) fail();
}

}  // namespace plslam::mapping
