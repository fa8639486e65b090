#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "vo_process/local_landmarks.h"

namespace plslam {

/// Features of a keyframe and the landmarks they belong to, in their order.
struct KeyframeContent {
  StereoFeatures features;
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

/// What the frames since the last keyframe saw of each landmark, so that a keyframe says all that they know and not only
/// what its own image shows.
///
/// A keyframe's measurement of a landmark becomes the mean over these frames: the landmark's projection in the keyframe
/// plus the weighted mean of what was measured minus what was projected in each frame. Errors of single frames average
/// out; those that all frames share (`kCommonShare` of the variance) stay. Measurements of different keyframes share no
/// frame, so adjustment may take them as independent. Landmarks that the keyframe's own detection missed, but frames before it
/// saw, are added as features: a detector finds a corner again in two of three frames only.
class KeyframeMeasurements {
 public:
  explicit KeyframeMeasurements(const StereoCamera& camera) : camera_(camera) {}

  /// A frame at `T_odom_c` whose tracks name their landmarks.
  void Add(const SE3& T_odom_c, const TrackedFrame& frame);

  /// `content`: that of the frame added last. What was collected is forgotten.
  KeyframeContent Take(const LocalLandmarks& landmarks, KeyframeContent content);

 private:
  struct PointSeen {
    int frame = 0;
    StereoPoint feature;
  };
  struct LineSeen {
    int frame = 0;
    StereoLine feature;
  };
  /// Means over `seen` as a feature of the last frame; `feature` says what it looks like. False, and nothing done, where
  /// they say nothing.
  bool Improve(const PointLandmark& landmark, const std::vector<PointSeen>& seen, StereoPoint& feature) const;
  bool Improve(const LineLandmark& landmark, const std::vector<LineSeen>& seen, StereoLine& feature) const;
  /// The feature as it should be in the last frame where that did not find it.
  bool Expect(const PointLandmark& landmark, StereoPoint& feature) const;
  bool Expect(const LineLandmark& landmark, StereoLine& feature) const;
  template <class Landmark, class Seen, class Feature>
  void ImproveAll(const std::vector<Landmark>& landmarks, const std::map<int64_t, std::vector<Seen>>& collected,
                  std::vector<Feature>& features, std::vector<FeatureTrack>& tracks) const;

  StereoCamera camera_;
  std::vector<SE3> T_c_odom_;
  std::map<int64_t, std::vector<PointSeen>> points_;
  std::map<int64_t, std::vector<LineSeen>> lines_;
};

}  // namespace plslam
