// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/tracker_state.h"

#include <exception>
#include <filesystem>
#include <stdexcept>
#include <type_traits>

#include "core/bus/transport/wire.h"
#include "core/errors/log.h"
#include "core/files/sealed_file.h"
#include "core/io/maps/map_file_fields.h"

namespace plslam::archive {

template <class Archive, Is<StereoCamera> T>
void Fields(Archive& a, T& c) {
  a(c.f_px, c.cx_px, c.cy_px, c.baseline_m, c.width_px, c.height_px, c.left_px, c.top_px, c.taken_f_px);
}

template <class Archive, Is<Keyframe> T>
void Fields(Archive& a, T& k) {
  a(k.name.session, k.t_ns, k.name.number, k.frame_id, k.previous_keyframe_id, k.T_prevkf_kf, k.covariance,
    k.T_odom_kf, k.up, k.inertial, k.state, k.lockstep, k.camera, k.features, k.point_landmark_ids,
    k.line_landmark_ids, k.point_map_ids, k.line_map_ids, k.withdrawn_points, k.withdrawn_lines, k.map_id);
}

/// The poses as encoded messages.
template <class Archive, Is<vo::TrackerSession> T>
void Fields(Archive& a, T& s) {
  std::vector<std::vector<uint8_t>> poses;
  for (const pose_t& pose : s.recent) poses.push_back(bus::Encoded(pose));
  a(s.id, s.lockstep, s.last_t_ns, s.last_frame_id, s.last_source, s.last_keyframe_id, s.follows_keyframe, s.anchor,
    s.map_id, poses);
  if constexpr (!std::is_const_v<T>) {
    s.recent.clear();
    for (const std::vector<uint8_t>& bytes : poses) {
      std::optional<pose_t> pose = bus::Decoded<pose_t>(bytes);
      if (!pose) throw std::runtime_error("a message in it is damaged");
      s.recent.push_back(std::move(*pose));
    }
  }
}

template <class Archive, Is<vo::TrackerState> T>
void Fields(Archive& a, T& s) {
  a(s.settings, s.camera, s.n_restored, s.session, s.adopted_keyframe_id, s.odometry, s.keyframe, s.localise_only,
    s.map_is_fixed);
}

}  // namespace plslam::archive

namespace plslam::vo {
namespace {

/// Increase the version with each change of the written data, including the fields of Odometry.
constexpr FileKind kTrackerState{
    {'P', 'L', 'S', 'L', 'V', 'O', 'S', 'T'}, 28, "state of a tracker", Checksum::kPoly1305};

/// Number of trackers that may continue one state: the state itself may be what crashes them.
constexpr int kMaxRestored = 5;

}  // namespace

size_t WriteTrackerState(const std::string& path, const TrackerState& state, size_t expected_bytes) {
  const std::vector<uint8_t> bytes = archive::ToBytesOf(expected_bytes, state);
  WriteSealedFile(path, kTrackerState, bytes);
  return bytes.size();
}

TrackerState ReadTrackerState(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadSealedFile(path, kTrackerState);
  return NamingFile(path, [&] {
    TrackerState state;
    archive::FromBytes(bytes, state);
    return state;
  });
}

std::optional<TrackerState> TrackerCheckpoint::Take(const std::string& settings) const {
  if (path_.empty() || !std::filesystem::exists(path_)) return std::nullopt;
  TrackerState state = ReadTrackerState(path_);
  if (state.settings != settings) throw std::runtime_error("the state was written by a tracker with other settings");
  if (++state.n_restored > kMaxRestored)
    throw std::runtime_error("all processes that resumed from this state have crashed");
  WriteTrackerState(path_, state);
  return state;
}

bool TrackerCheckpoint::Keep(const TrackerState& state) {
  if (path_.empty()) return false;
  try {
    bytes_ = WriteTrackerState(path_, state, bytes_ + bytes_ / 8);
    odometry_bytes_ = state.odometry.size();
    return true;
  } catch (const std::exception& error) {
    Drop();
    if (!std::exchange(has_failed_, true)) LogWarning("the state for a restart is not written: {}", error.what());
    return false;
  }
}

void TrackerCheckpoint::Release() const {
  if (path_.empty() || !std::filesystem::exists(path_)) return;
  try {
    TrackerState state = ReadTrackerState(path_);
    if (std::exchange(state.n_restored, 0) > 0) WriteTrackerState(path_, state);
  } catch (const std::exception& error) {
    LogWarning("{}", error.what());
  }
}

void TrackerCheckpoint::Drop() const {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove(path_, ignored);
}

}  // namespace plslam::vo
