// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "vo_process/tracking/landmark_list.h"
#include "vo_process/tracking/local_landmarks.h"

namespace plslam::vo {

/// Features of a keyframe and the landmarks they belong to, in their order.
struct KeyframeContent {
  StereoFeatures features;
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

/// What the frames since the last keyframe saw of each landmark, so that a keyframe says all that they know and not
/// only what its own image shows.
///
/// A keyframe's measurement of a landmark becomes the mean over these frames: the landmark's projection in the
/// keyframe plus the weighted mean of what was measured minus what was projected in each frame. Errors of single
/// frames average out; those that all frames share (`kCommonShare` of the variance) stay. Measurements of different
/// keyframes share no frame, so adjustment may take them as independent. Landmarks that the keyframe's own detection
/// missed, but frames before it saw, are added as features: a detector finds a corner again in two of three frames
/// only.
class KeyframeMeasurements {
 public:
  /// Of a camera that stands no frames before these are kept: a mean over more is no better, and there is no end to
  /// them.
  static constexpr size_t kMaxFrames = 100;

  explicit KeyframeMeasurements(const StereoCamera& camera) : camera_(camera) {}

  /// A frame at `T_odom_c` whose tracks name their landmarks.
  void Add(const SE3& T_odom_c, const TrackedFrame& frame);

  /// `content`: that of the frame added last. What was collected is forgotten.
  KeyframeContent Take(const LocalLandmarks& landmarks, KeyframeContent content);

 private:
  template <class Feature>
  struct Named {
    int64_t landmark_id = -1;
    Feature feature;
  };
  struct Frame {
    SE3 T_c_odom;
    std::vector<Named<StereoPoint>> points;
    std::vector<Named<StereoLine>> lines;
  };
  /// A feature that a landmark was seen as, and from where.
  template <class Feature>
  struct Seen {
    const SE3* T_c_odom = nullptr;
    const Feature* feature = nullptr;
  };
  template <class Feature>
  using Observations = std::span<const std::pair<int64_t, Seen<Feature>>>;

  /// Means over `seen` as a feature of the last frame; `feature` says what it looks like. False, and nothing done,
  /// where they say nothing.
  bool Improve(const PointLandmark& landmark, Observations<StereoPoint> seen, StereoPoint& feature) const;
  bool Improve(const LineLandmark& landmark, Observations<StereoLine> seen, StereoLine& feature) const;
  bool ImproveDisparities(const LineLandmark& landmark, Observations<StereoLine> seen, const Segment2& right,
                          StereoLine& feature) const;
  /// The feature as it should be in the last frame where that did not find it.
  bool Expect(const PointLandmark& landmark, StereoPoint& feature) const;
  bool Expect(const LineLandmark& landmark, StereoLine& feature) const;
  /// By landmark, in the order of the frames.
  template <class Feature>
  IdIndex<Seen<Feature>> Collect(std::vector<Named<Feature>> Frame::*of) const;
  template <class Landmark, class Feature>
  void ImproveAll(const std::vector<Landmark>& landmarks, const IdIndex<Seen<Feature>>& collected,
                  std::vector<Feature>& features, std::vector<FeatureTrack>& tracks) const;

  StereoCamera camera_;
  std::deque<Frame> frames_;
};

}  // namespace plslam::vo
