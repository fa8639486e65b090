#include "vo_process/node/tracker_state.h"

#include "core/io/files/sealed_file.h"
#include "core/io/maps/map_file_fields.h"

namespace plslam {
namespace archive {

template <class Archive, Is<Keyframe> T>
void Fields(Archive& a, T& k) {
  a(k.session, k.t_ns, k.keyframe_id, k.frame_id, k.previous_keyframe_id, k.T_prevkf_kf, k.covariance, k.T_odom_kf,
    k.state, k.lockstep, k.features, k.point_landmark_ids, k.line_landmark_ids, k.point_map_ids, k.line_map_ids);
}

template <class Archive, Is<TrackerState> T>
void Fields(Archive& a, T& s) {
  a(s.settings, s.camera, s.n_restored, s.session, s.lockstep, s.t_ns, s.frame_id, s.source, s.poses,
    s.adrift_since_ns, s.adopted_keyframe_id, s.odometry, s.keyframe);
}

}  // namespace archive

namespace {

/// To be counted up with each change of what is written, of the fields of Odometry, too.
constexpr FileKind kTrackerState{
    {'P', 'L', 'S', 'L', 'V', 'O', 'S', 'T'}, 4, "state of a tracker", Checksum::kPoly1305};

}  // namespace

void WriteTrackerState(const std::string& path, const TrackerState& state) {
  WriteSealedFile(path, kTrackerState, archive::ToBytes(state));
}

TrackerState ReadTrackerState(const std::string& path) {
  const std::vector<uint8_t> bytes = ReadSealedFile(path, kTrackerState);
  return NamingFile(path, [&] {
    TrackerState state;
    archive::FromBytes(bytes, state);
    return state;
  });
}

}  // namespace plslam
