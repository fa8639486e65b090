// SPDX-License-Identifier: BSD-3-Clause
#include "dense_process/node/surfaces_on_disk.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <utility>

#include "core/errors/error_text.h"
#include "core/errors/log.h"

namespace plslam::dense {
namespace {

// The state is written after so many keyframes, and when the map has grown by a quarter: its cost is in proportion to
// the map.
constexpr size_t kStateEvery = 10;

void WriteSurfaces(const std::string& path, const DenseMap& surfaces, const Map& map) {
  surfaces.Write(path, PosesOf(map), LastingPosesOf(map));
}

}  // namespace

SurfacesOnDisk::SurfacesOnDisk(const DenseOptions& options)
    : state_file_(options.state_file), map_file_(options.map_file) {
  std::filesystem::create_directories(options.out);
}

std::string SurfacesOnDisk::Earlier() const {
  const bool has_state = !state_file_.empty() && std::filesystem::exists(state_file_);
  return has_state ? state_file_ : map_file_;
}

void SurfacesOnDisk::Fused(const DenseMap& surfaces, const Map& map) {
  if (++n_since_state_ >= std::max<size_t>(kStateEvery, surfaces.n_keyframes() / 4)) KeepState(surfaces, map);
}

void SurfacesOnDisk::KeepState(const DenseMap& surfaces, const Map& map) {
  if (state_file_.empty() || n_since_state_ == 0) return;
  n_since_state_ = 0;
  try {
    WriteSurfaces(state_file_, surfaces, map);
  } catch (const std::exception& error) {
    if (!std::exchange(state_failed_, true)) LogWarning("the state for a restart is not written: {}", error.what());
  }
}

std::string SurfacesOnDisk::SaveBeside(const std::string& map_file, const DenseMap* surfaces, const Map& map) {
  const std::string file = map_file + ".surfaces";
  try {
    if (surfaces == nullptr) {
      std::filesystem::remove(file);
    } else {
      WriteSurfaces(file, *surfaces, map);
    }
    return "";
  } catch (const std::exception& error) {
    save_failure_ = error.what();
    return save_failure_;
  }
}

std::string SurfacesOnDisk::Failures() const { return Joined(failure_, save_failure_); }

}  // namespace plslam::dense
