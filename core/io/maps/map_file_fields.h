// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdlib>
#include <stdexcept>
#include <type_traits>

#include "core/features/features.h"
#include "core/files/archive.h"
#include "core/ids/ids.h"
#include "core/io/maps/map_file.h"

// The fields of everything in a map file, in their order there: one list for writing and for reading.
namespace plslam::archive {

template <class Archive, Is<StoredSession> T>
void Fields(Archive& a, T& session) {
  a(session.keyframe_id, session.session_keyframe_id);
}

template <class Archive, Is<MapKeyframe> T>
void Fields(Archive& a, T& k) {
  a(k.id, k.name, k.frame_id, k.t_ns, k.T_w_kf, k.covariance, k.T_odom_kf, k.previous_id, k.T_prevkf_kf,
    k.relative_covariance, k.parent_id);
}

template <class Archive, Is<StereoPoint> T>
void Fields(Archive& a, T& p) {
  a(p.left.px, p.left.response, p.left.angle_rad, p.left.octave, p.left.descriptor, p.left.scale, p.disparity_px,
    p.sigma_px, p.sigma_disparity_px);
}

template <class Archive, Is<StereoLine> T>
void Fields(Archive& a, T& l) {
  a(l.left.segment.p, l.left.segment.q, l.left.response, l.left.octave, l.left.descriptor, l.disparity_p_px,
    l.disparity_q_px, l.sigma_px, l.sigma_disparity_p_px, l.sigma_disparity_q_px);
}

template <class Archive, Is<TakenImage> T>
void Fields(Archive& a, T& image) {
  a(image.left_px, image.top_px, image.width_px, image.height_px, image.f_px);
}

/// Without the image: few keyframes have a separate one.
template <class Archive, class T>
requires Is<T, StereoFeatures> || Is<T, FeaturesView>
void Fields(Archive& a, T& features) { a(features.points, features.lines); }

template <class Archive, Is<Observation> T>
void Fields(Archive& a, T& observation) {
  KeyframeId keyframe_id = observation.keyframe_id();
  int32_t feature = observation.feature;
  a(keyframe_id, feature);
  if constexpr (!std::is_const_v<T>) {
    if (std::abs(keyframe_id.value) > Observation::kMaxId || std::abs(int64_t{feature}) > Observation::kMaxFeature)
      throw std::runtime_error("an observation has an invalid keyframe or feature");
    observation = {keyframe_id, feature};
  }
}

/// Whole and in double precision, as the first files had it.
template <class Archive, Is<LandmarkCovariance> T>
void Fields(Archive& a, T& covariance) {
  Eigen::Matrix3d full = covariance;
  a(full);
  if constexpr (!std::is_const_v<T>) covariance = full;
}

template <class Archive, Is<MapPoint> T>
void Fields(Archive& a, T& p) {
  a(p.id, p.p_w, p.covariance, p.descriptor, p.angle_rad, p.octave, p.depth_m, p.observations);
}

template <class Archive, Is<MapLine> T>
void Fields(Archive& a, T& l) {
  a(l.id, l.segment_w.p, l.segment_w.q, l.covariance_p, l.covariance_q, l.descriptor, l.observations);
}

template <class Archive, Is<LoopEdge> T>
void Fields(Archive& a, T& loop) {
  a(loop.old_keyframe_id, loop.keyframe_id, loop.T_old_kf, loop.covariance, loop.n_points, loop.n_lines);
}

/// The scalar fields of a stored map.
template <class Archive, Is<StoredMap> T>
void Fields(Archive& a, T& stored) {
  a(stored.version, stored.rig, stored.next_keyframe_id, stored.next_point_id, stored.next_line_id,
    stored.newest_session, stored.newest_t_ns);
}

}  // namespace plslam::archive
