// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/keyframe_maker.h"

#include <algorithm>
#include <utility>

#include "vo_process/tracking/landmarks/frame_figures.h"

namespace plslam::vo {
namespace {

// Features of a frame for a keyframe, except those on bodies, which must not enter a map.
KeyframeContent ContentOfWorld(const TrackedFrame& frame) {
  KeyframeContent content;
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    if (!frame.point_tracks[i].IsOfWorld()) continue;
    content.features.points.push_back(frame.features.points[i]);
    content.point_tracks.push_back(frame.point_tracks[i]);
  }
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    if (!frame.line_tracks[i].IsOfWorld()) continue;
    content.features.lines.push_back(frame.features.lines[i]);
    content.line_tracks.push_back(frame.line_tracks[i]);
  }
  return content;
}

}  // namespace

KeyframeMaker::KeyframeMaker(const StereoCamera& camera, const KeyframeOptions& options)
    : camera_(camera), options_(options), policy_(options), measurements_(camera) {}

void KeyframeMaker::BeginSession() {
  next_id_ = 0;
  log_ = {};
  begins_session_ = true;
}

KeyframeDecision KeyframeMaker::Decide(const TrackedFrame& frame, const SE3& T_odom_c, const Matrix6d& covariance,
                                       bool map_grows) {
  KeyframeCandidate candidate;
  candidate.T_kf_c = SinceKeyframe(T_odom_c);
  candidate.covariance = covariance;
  candidate.tracked_from_keyframe = TrackedFromKeyframe(frame);
  candidate.median_depth_m = MedianDepth(frame, camera_);
  if (map_grows) candidate.known_share = KnownShare(frame, options_.known_observations);
  return policy_.Decide(candidate);
}

int KeyframeMaker::TrackedFromKeyframe(const TrackedFrame& frame) const {
  const auto known_below = [](TrackId limit) {
    return [limit](const FeatureTrack& track) {
      return track.landmark_id >= 0 && track.landmark_id < limit && track.IsOfWorld();
    };
  };
  const auto points =
      std::count_if(frame.point_tracks.begin(), frame.point_tracks.end(), known_below(first_unknown_point_));
  const auto lines =
      std::count_if(frame.line_tracks.begin(), frame.line_tracks.end(), known_below(first_unknown_line_));
  return static_cast<int>(points + 2 * lines);
}

KeyframeStep KeyframeMaker::Make(KeyframeReason reason, const SE3& T_odom_c, const Matrix6d& covariance,
                                 const LocalLandmarks& landmarks) {
  KeyframeStep step;
  step.id = next_id_++;
  step.reason = reason;
  if (step.id > 0) {
    step.previous_id = step.id - 1;
    step.T_prevkf_kf = SinceKeyframe(T_odom_c);
    step.covariance = covariance;
  }
  begins_session_ = false;
  T_odom_kf_ = T_odom_c;
  first_unknown_point_ = landmarks.next_point_id;
  first_unknown_line_ = landmarks.next_line_id;
  policy_.Restart();
  return step;
}

void KeyframeMaker::Add(const SE3& T_odom_c, const TrackedFrame& frame) { measurements_.Add(T_odom_c, frame); }

KeyframeContent KeyframeMaker::TakeContent(int64_t keyframe_id, const TrackedFrame& frame,
                                           const LocalLandmarks& landmarks) {
  KeyframeContent content = measurements_.Take(landmarks, ContentOfWorld(frame));
  log_.Add(keyframe_id, TrackedLandmarkIds(content.point_tracks), TrackedLandmarkIds(content.line_tracks));
  return content;
}

}  // namespace plslam::vo
