// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/mapper_state.h"

#include "core/io/files/archive.h"
#include "core/io/files/sealed_file.h"

namespace plslam::mapping {
namespace {

constexpr FileKind kStateFile{{'P', 'L', 'S', 'L', 'M', 'P', 'S', 'T'}, 4, "state of a mapping_process"};

}  // namespace

}  // namespace plslam::mapping

namespace plslam::archive {

template <class Archive, Is<AdjustmentFigures> T>
void Fields(Archive& a, T& f) {
  a(f.n_keyframes, f.n_fixed_keyframes, f.n_points, f.n_lines, f.n_outliers, f.rms_before, f.rms_after,
    f.reprojection_before_px, f.reprojection_after_px);
}

/// All but the map, whose bytes are those of a map file.
template <class Archive, Is<mapping::MapperState> T>
void Fields(Archive& a, T& state) {
  a(state.recent_landmarks, state.tracker, state.figures, state.committed, state.structural_version,
    state.localise_only, state.began_version);
}

}  // namespace plslam::archive

namespace plslam::mapping {

std::vector<uint8_t> EncodeState(const MapperState& state) {
  // As `archive::FromBytes` reads a list of bytes and the rest; a large map is not copied for that.
  archive::Writer write;
  write(uint64_t{0});
  AppendMap(state.stored, write);
  const uint64_t length = write.size() - sizeof(length);
  write.Overwrite(0, &length, sizeof(length));
  write(state);
  return std::move(write).Take();
}

MapperState DecodeState(std::span<const uint8_t> bytes) {
  MapperState state;
  std::vector<uint8_t> map;
  archive::FromBytes(bytes, map, state);
  state.stored = DecodeMap(map);
  return state;
}

void WriteStateFile(const std::string& path, const MapperState& state) {
  WriteSealedFile(path, kStateFile, EncodeState(state));
}

MapperState ReadStateFile(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadSealedFile(path, kStateFile);
  return NamingFile(path, [&] { return DecodeState(bytes); });
}

}  // namespace plslam::mapping
