// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <future>
#include <memory>
#include <stdexcept>

#include "core/errors/error_text.h"
#include "core/io/files/atomic_file.h"
#include "core/io/files/sealed_file.h"
#include "core/io/maps/map_file_check.h"
#include "core/io/maps/map_file_fields.h"

namespace plslam {
namespace {

using Bytes = std::span<const uint8_t>;
/// Format 2 ends with the images of keyframes that another camera has seen. Where there are none, format 1 is written,
/// which older programs read.
constexpr uint64_t kWithoutImages = 1;
constexpr FileKind kMapFile{
    {'P', 'L', 'S', 'L', 'A', 'M', 'A', 'P'}, 2, "map file", Checksum::kBlake2b, kWithoutImages};
constexpr FileKind kMapFileWithoutImages{{'P', 'L', 'S', 'L', 'A', 'M', 'A', 'P'}, kWithoutImages, "map file"};

/// Reads landmarks of one kind into the map; returns how many observations they have.
template <class Landmark>
int64_t ReadLandmarks(archive::Reader& read, StoredMap& stored) {
  int64_t last_id = -1;
  int64_t n_observations = 0;
  for (uint64_t n = read.ReadCount(archive::MinBytes<Landmark>()); n > 0; --n) {
    Landmark landmark;
    read(landmark);
    map_file::Check(landmark, stored.features);
    if (landmark.id <= last_id) throw std::runtime_error("landmarks do not ascend");
    last_id = landmark.id;
    n_observations += static_cast<int64_t>(landmark.observations.size());
    stored.map.Put(landmark);
  }
  return n_observations;
}

void ReadKeyframes(archive::Reader& read, StoredMap& stored) {
  int64_t last_id = -1;
  for (uint64_t n = read.ReadCount(archive::MinBytes<MapKeyframe>()); n > 0; --n) {
    MapKeyframe keyframe;
    read(keyframe);
    map_file::Check(keyframe);
    if (keyframe.id <= last_id) throw std::runtime_error("keyframes do not ascend");
    last_id = keyframe.id;
    stored.map.Put(keyframe);
  }
}

/// Values by number, ascending.
template <class Value>
void ReadMap(archive::Reader& read, std::map<int64_t, Value>& values) {
  for (uint64_t n = read.ReadCount(sizeof(int64_t) + archive::MinBytes<Value>()); n > 0; --n) {
    int64_t id = 0;
    read(id);
    if (!values.empty() && id <= values.rbegin()->first) throw std::runtime_error("numbers do not ascend");
    read(values.try_emplace(values.end(), id)->second);
  }
}

std::map<int64_t, TakenImage> ImagesOf(const StoredMap& stored) {
  std::map<int64_t, TakenImage> images;
  for (const auto& [id, features] : stored.features) {
    if (features.image) images[id] = *features.image;
  }
  return images;
}

void ReadImages(archive::Reader& read, StoredMap& stored) {
  std::map<int64_t, TakenImage> images;
  ReadMap(read, images);
  for (const auto& [id, image] : images) {
    map_file::Check(id, image, stored.features);
    stored.features.at(id).image = image;
  }
}

StoredMap ReadContent(uint64_t format, Bytes content) {
  StoredMap stored;
  archive::Reader read(content);
  read(stored);
  ReadMap(read, stored.sessions);
  ReadKeyframes(read, stored);
  ReadMap(read, stored.features);
  for (const auto& [id, features] : stored.features) map_file::Check(id, features);
  const int64_t point_observations = ReadLandmarks<MapPoint>(read, stored);
  const int64_t line_observations = ReadLandmarks<MapLine>(read, stored);
  std::vector<LoopEdge> loops;
  read(loops);
  for (const LoopEdge& loop : loops) {
    map_file::Check(loop);
    stored.map.Add(loop);
  }
  if (format != kWithoutImages) ReadImages(read, stored);
  if (!read.AtEnd()) throw std::runtime_error("the content has more than it promises");
  map_file::CheckWhole(stored, point_observations, line_observations);
  stored.map.TakeChanges();
  return stored;
}

/// The content is read while another thread sums it up, which takes as long.
StoredMap ReadAndCheck(const Seal& seal, Bytes content) {
  auto check = std::async(std::launch::async, [&] { CheckSeal(kMapFile, seal, content); });
  StoredMap stored;
  try {
    stored = ReadContent(seal.format, content);
  } catch (const std::runtime_error&) {
    check.get();
    throw;
  }
  check.get();
  return stored;
}

template <class Value>
void WriteValues(archive::Writer& write, const IdMap<Value>& values) {
  write(static_cast<uint64_t>(values.size()));
  for (const auto& [id, value] : values) write(value);
}

void CheckAll(const StoredMap& stored) {
  for (const auto& [id, keyframe] : stored.map.keyframes()) map_file::Check(keyframe);
  for (const auto& [id, features] : stored.features) {
    map_file::Check(id, features);
    if (features.image) map_file::Check(id, *features.image, stored.features);
  }
  for (const auto& [id, point] : stored.map.points()) map_file::Check(point, stored.features);
  for (const auto& [id, line] : stored.map.lines()) map_file::Check(line, stored.features);
  for (const LoopEdge& loop : stored.map.loops()) map_file::Check(loop);
  const MapTotals totals = stored.map.Totals();
  map_file::CheckWhole(stored, totals.point_observations, totals.line_observations);
}

/// A little more than it will be.
size_t RoughLength(const StoredMap& stored) {
  using archive::MinBytes;
  const MapTotals totals = stored.map.Totals();
  size_t n = stored.rig.size() + stored.map.loops().size() * MinBytes<LoopEdge>() +
             static_cast<size_t>(totals.keyframes) * (MinBytes<MapKeyframe>() + 64) +
             static_cast<size_t>(totals.points) * MinBytes<MapPoint>() +
             static_cast<size_t>(totals.lines) * MinBytes<MapLine>() +
             static_cast<size_t>(totals.point_observations + totals.line_observations) * MinBytes<Observation>();
  for (const auto& [id, features] : stored.features) {
    n += features.points.size() * MinBytes<StereoPoint>() + features.lines.size() * MinBytes<StereoLine>();
  }
  return n + 4096;
}

}  // namespace

void AppendMap(const StoredMap& stored, archive::Writer& write) {
  CheckAll(stored);
  write.Reserve(RoughLength(stored));
  const size_t begin = write.size();
  // The seal's place; what it says is known at the end.
  write(std::vector<uint8_t>(sizeof(Seal) - sizeof(uint64_t)), stored);
  write(stored.sessions);
  WriteValues(write, stored.map.keyframes());
  write(stored.features);
  WriteValues(write, stored.map.points());
  WriteValues(write, stored.map.lines());
  write(stored.map.loops());
  const std::map<int64_t, TakenImage> images = ImagesOf(stored);
  if (!images.empty()) write(images);
  const Seal seal =
      MakeSeal(images.empty() ? kMapFileWithoutImages : kMapFile, write.Written().subspan(begin + sizeof(Seal)));
  write.Overwrite(begin, &seal, sizeof(Seal));
}

std::vector<uint8_t> EncodeMap(const StoredMap& stored) {
  archive::Writer write;
  AppendMap(stored, write);
  return std::move(write).Take();
}

StoredMap DecodeMap(std::span<const uint8_t> bytes) {
  const Seal seal = ReadSeal(kMapFile, bytes, bytes.size());
  return ReadAndCheck(seal, bytes.subspan(sizeof(Seal)));
}

void WriteMapFile(const std::string& path, const StoredMap& stored) {
  if (stored.map.keyframes().empty()) throw std::runtime_error(path + ": is not written: the map has no keyframe");
  const std::vector<uint8_t> bytes = NamingFile(path, [&] { return EncodeMap(stored); });
  WriteFileAtomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

StoredMap ReadMapFile(const std::string& path) {
  return NamingFile(path, [&] {
    SealedFileReader file(path, kMapFile);
    const uint64_t length = file.seal().length;
    return WithMemoryFor(fmt::format("{} bytes of map", length), [&] {
      // Not a vector: its bytes would be set to zero first.
      const std::unique_ptr<uint8_t[]> content(new uint8_t[length]);
      file.Read(content.get());
      return ReadAndCheck(file.seal(), {content.get(), length});
    });
  });
}

}  // namespace plslam
