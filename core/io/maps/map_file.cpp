// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <future>
#include <memory>
#include <stdexcept>

#include "core/errors/error_text.h"
#include "core/files/sealed_file.h"
#include "core/io/maps/map_records.h"

namespace plslam {
namespace {

using Bytes = std::span<const uint8_t>;
/// Format 2 ends with the images of keyframes that another camera has seen, format 3 with these and the verticals of
/// keyframes. The lowest format that holds the map is written, because older programs can read it.
constexpr uint64_t kPlain = 1, kWithImages = 2, kWithUps = 3;

constexpr FileKind KindOf(uint64_t format) {
  return {{'P', 'L', 'S', 'L', 'A', 'M', 'A', 'P'}, format, "map file", Checksum::kBlake2b, kPlain};
}
constexpr FileKind kMapFile = KindOf(kWithUps);

/// Content that only some maps have.
struct Extras {
  std::map<KeyframeId, TakenImage> images;
  std::map<KeyframeId, UpDirection> ups;

  uint64_t Format() const {
    if (!ups.empty()) return kWithUps;
    return images.empty() ? kPlain : kWithImages;
  }
};

Extras ExtrasOf(const StoredMap& stored) {
  Extras extras;
  for (const auto& [id, features] : stored.features) {
    if (features.image) extras.images[id] = *features.image;
  }
  extras.ups = map_file::UpDirectionsOf(stored.map);
  return extras;
}

StoredMap ReadContent(uint64_t format, Bytes content) {
  StoredMap stored;
  archive::Reader read(content);
  read(stored);
  map_file::ReadByNumber(read, stored.sessions);
  map_file::ReadKeyframes(read, stored);
  map_file::ReadFeatures(read, stored.features);
  const int64_t point_observations = map_file::ReadLandmarks<MapPoint>(read, stored);
  const int64_t line_observations = map_file::ReadLandmarks<MapLine>(read, stored);
  map_file::ReadLoops(read, stored.map);
  if (format >= kWithImages) map_file::ReadImages(read, stored.features);
  if (format >= kWithUps) map_file::ReadUpDirections(read, stored.map);
  if (!read.AtEnd()) throw std::runtime_error("the content is longer than stated in its header");
  map_file::CheckObservationsOnce(stored.map, point_observations, line_observations);
  map_file::CheckWhole(stored);
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

void CheckAll(const StoredMap& stored) {
  for (const auto& [id, keyframe] : stored.map.keyframes()) {
    map_file::Check(keyframe);
    if (keyframe.up) map_file::Check(id, *keyframe.up, stored.map);
  }
  for (const auto& [id, features] : stored.features) {
    map_file::Check(id, features);
    if (features.image) map_file::Check(id, *features.image, stored.features);
    features.LeaveMemory();
  }
  for (const auto& [id, point] : stored.map.points()) map_file::Check(point, stored.features);
  for (const auto& [id, line] : stored.map.lines()) map_file::Check(line, stored.features);
  for (const LoopEdge& loop : stored.map.loops()) map_file::Check(loop);
  map_file::CheckWhole(stored);
}

void WriteContent(const StoredMap& stored, const Extras& extras, archive::Writer& write) {
  write(stored, stored.sessions);
  map_file::WriteValues(write, stored.map.keyframes());
  write(static_cast<uint64_t>(stored.features.size()));
  for (const auto& [id, features] : stored.features) {
    write(id, static_cast<const FeaturesView&>(features));
    features.LeaveMemory();
  }
  map_file::WriteValues(write, stored.map.points());
  map_file::WriteValues(write, stored.map.lines());
  write(stored.map.loops());
  if (extras.Format() >= kWithImages) write(extras.images);
  if (extras.Format() >= kWithUps) write(extras.ups);
}

/// Returns the number of bytes that `WriteContent` writes.
size_t LengthOf(const StoredMap& stored, const Extras& extras) {
  using archive::MinBytes;
  constexpr size_t kNumber = sizeof(int64_t);
  archive::Writer head;
  head(stored, stored.sessions);
  const MapTotals totals = stored.map.Totals();
  size_t n = head.size() + 5 * kNumber + stored.map.loops().size() * MinBytes<LoopEdge>() +
             static_cast<size_t>(totals.keyframes) * MinBytes<MapKeyframe>() +
             static_cast<size_t>(totals.points) * MinBytes<MapPoint>() +
             static_cast<size_t>(totals.lines) * MinBytes<MapLine>() +
             static_cast<size_t>(totals.point_observations + totals.line_observations) * MinBytes<Observation>();
  for (const auto& [id, features] : stored.features) {
    n += kNumber + MinBytes<StereoFeatures>() + features.points.size() * MinBytes<StereoPoint>() +
         features.lines.size() * MinBytes<StereoLine>();
  }
  if (extras.Format() >= kWithImages) n += kNumber + extras.images.size() * (kNumber + MinBytes<TakenImage>());
  if (extras.Format() >= kWithUps) n += kNumber + extras.ups.size() * (kNumber + MinBytes<UpDirection>());
  return n;
}

}  // namespace

std::vector<uint8_t> EncodeMap(const StoredMap& stored) {
  CheckAll(stored);
  const Extras extras = ExtrasOf(stored);
  archive::Writer write(sizeof(Seal) + LengthOf(stored, extras));
  // Reserves space for the seal, which is computed at the end.
  write(std::array<uint8_t, sizeof(Seal)>());
  WriteContent(stored, extras, write);
  const Seal seal = MakeSeal(KindOf(extras.Format()), write.Written().subspan(sizeof(Seal)));
  write.Overwrite(0, &seal, sizeof(Seal));
  return std::move(write).Take();
}

StoredMap DecodeMap(std::span<const uint8_t> bytes) {
  const Seal seal = ReadSeal(kMapFile, bytes, bytes.size());
  return ReadAndCheck(seal, bytes.subspan(sizeof(Seal)));
}

void WriteMapFile(const std::string& path, const StoredMap& stored) {
  if (stored.map.keyframes().empty()) throw std::runtime_error(path + ": is not written: the map has no keyframes");
  NamingFile(path, [&] { CheckAll(stored); });
  const Extras extras = ExtrasOf(stored);
  SealedFileWriter file(path, KindOf(extras.Format()), LengthOf(stored, extras));
  archive::Writer write([&](Bytes content) { file.Append(content); });
  WriteContent(stored, extras, write);
  write.Flush();
  file.PutInPlace(/*survives_power_cut=*/true);
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
