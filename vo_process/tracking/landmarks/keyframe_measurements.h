// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "vo_process/tracking/landmarks/landmark_list.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"

namespace plslam::vo {

/// Features of a keyframe and their landmarks, in the same order.
struct KeyframeContent {
  StereoFeatures features;
  std::vector<FeatureTrack> point_tracks;
  std::vector<FeatureTrack> line_tracks;
};

/// Measurements of each landmark in the frames since the last keyframe, which a keyframe combines with its own image.
///
/// A keyframe's measurement of a landmark becomes the mean over these frames: the landmark's projection into the
/// keyframe plus the weighted mean of measured minus projected position in each frame. Errors of single frames average
/// out; those common to all frames (`kCommonShare` of the variance) remain. A point that is followed repeats the error of
/// its detection, so each detection counts once, and that of the last keyframe's image only where there is no later one.
/// Then measurements of different keyframes have no error in common, and adjustment may treat them as independent.
/// Landmarks that were not detected in the keyframe, but in earlier frames (points: in two), are added as features,
/// because a detector repeats a corner in only two of three frames.
class KeyframeMeasurements {
 public:
  /// Number of latest frames kept when the camera stands: a mean over more is no better, and their number is unbounded.
  static constexpr size_t kMaxFrames = 100;

  explicit KeyframeMeasurements(const StereoCamera& camera) : camera_(camera) {}

  /// Adds a frame at `T_odom_c`, using the landmark ids of its tracks.
  void Add(const SE3& T_odom_c, const TrackedFrame& frame);

  /// Returns the improved `content`, which must be that of the last added frame, and clears the frames.
  KeyframeContent Take(const LocalLandmarks& landmarks, KeyframeContent content);

 private:
  template <class Feature>
  struct Named {
    TrackId landmark_id = -1;
    Feature feature;
  };
  struct Frame {
    SE3 T_c_odom;
    int detection = 0;  ///< number of the frame in which its points were detected
    std::vector<Named<StereoPoint>> points;
    std::vector<Named<StereoLine>> lines;
  };
  /// A feature as which a landmark was observed, and the pose of its frame.
  template <class Feature>
  struct Seen {
    const SE3* T_c_odom = nullptr;
    const Feature* feature = nullptr;
    int detection = 0;
  };
  template <class Feature>
  using Observations = std::span<const std::pair<TrackId, Seen<Feature>>>;

  /// Sets `feature` of the last frame to the mean over `seen`; the appearance stays. Returns false and does nothing if
  /// they do not determine it.
  bool Improve(const PointLandmark& landmark, Observations<StereoPoint> seen, StereoPoint& feature) const;
  bool Improve(const LineLandmark& landmark, Observations<StereoLine> seen, StereoLine& feature) const;
  bool ImproveDisparities(const LineLandmark& landmark, Observations<StereoLine> seen, const Segment2& right,
                          StereoLine& feature) const;
  /// Predicts the feature in the last frame, if that did not detect it.
  bool Expect(const PointLandmark& landmark, StereoPoint& feature) const;
  bool Expect(const LineLandmark& landmark, StereoLine& feature) const;
  /// By landmark, in the order of the frames.
  template <class Feature>
  IdIndex<TrackId, Seen<Feature>> Collect(std::vector<Named<Feature>> Frame::*of) const;
  template <class Landmark, class Feature>
  void ImproveAll(const std::vector<Landmark>& landmarks, const IdIndex<TrackId, Seen<Feature>>& collected,
                  std::vector<Feature>& features, std::vector<FeatureTrack>& tracks) const;

  StereoCamera camera_;
  std::deque<Frame> frames_;
};

}  // namespace plslam::vo
