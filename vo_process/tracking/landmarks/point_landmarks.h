// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "core/motion/motion_estimator.h"
#include "vo_process/options.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"
#include "vo_process/tracking/landmarks/tracker_local_map.h"

namespace plslam::vo {

/// A point tracked by odometry.
struct PointLandmark {
  TrackId id = -1;
  /// Position in the odometry frame, and its covariance given the poses of the observations.
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Values of the last observation.
  Descriptor descriptor{};
  float angle_rad = 0.0F;
  int octave = 0;
  double depth_m = 0.0;

  /// The same landmark in the map, or -1.
  LandmarkId map_id = -1;
  /// Number of keyframes that observe it, as of the last map update.
  int map_observations = 0;
  int seen = 1;
  int unseen_frames = 0;
  int missed = 0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.id, self.p_odom, self.covariance, self.descriptor, self.angle_rad, self.octave, self.depth_m, self.map_id,
      self.map_observations, self.seen, self.unseen_frames, self.missed);
  }
};

/// Points in and around the view, each fused over the frames that observed it. Sibling of `LineLandmarks`.
class PointLandmarks {
 public:
  PointLandmarks(const StereoCamera& camera, const OrbOptions& orb, const LandmarkOptions& options)
      : camera_(camera), orb_(orb), options_(options) {}

  const std::vector<PointLandmark>& landmarks() const { return landmarks_; }

  /// Matches landmarks near their projection with the predicted pose.
  std::vector<LandmarkMatch> MatchByProjection(const SE3& T_c_odom, const TrackedFrame& frame, const Search& search,
                                               const MatchOptions& options) const;

  /// Matches by descriptors alone, for frames whose pose cannot be predicted.
  std::vector<LandmarkMatch> MatchByDescriptor(const TrackedFrame& frame, int max_unseen_frames,
                                               const MatchOptions& options) const;

  /// Returns the correspondence for the motion estimator of each match.
  std::vector<PointCorrespondence> Observations(const std::vector<LandmarkMatch>& matches,
                                                const TrackedFrame& frame) const;

  /// Fuses the frame's observations of the matched landmarks, sets their ids in the frame's tracks, and ages the
  /// others.
  void Update(const SE3& T_odom_c, const std::vector<LandmarkMatch>& matches, TrackedFrame& frame);

  /// Adopts landmarks of the map: updates position and covariance of those already here (of several that are the same
  /// the oldest stays), and adds the others.
  void Adopt(const SE3& T_odom_w, const std::vector<Adopted<MapPoint>>& adopted, double map_f_px, TrackId& next_id);

  /// Re-expresses all landmarks in a new frame.
  void Move(const SE3& T_new_odom);

  /// Makes all landmarks take part in the next search, as if the last frame had observed them.
  void CountAsSeen() {
    for (auto& landmark : landmarks_) landmark.unseen_frames = 0;
  }

  /// Moves the landmarks flagged in `taken` to a list of their own.
  PointLandmarks Take(const std::vector<char>& taken);

  /// Returns a list of the landmarks flagged in `chosen`.
  PointLandmarks Copy(const std::vector<char>& chosen) const;

  /// Appends copies of the landmarks of another list in the same frame.
  void Append(const PointLandmarks& others);

  /// Creates a landmark for each feature with depth that has none and is on this body (-1: the world), and sets its id
  /// in the frame's tracks.
  void Create(const SE3& T_odom_c, TrackedFrame& frame, TrackId& next_id, int body = -1);

  /// Removes all landmarks, and creates one for each feature of the world with depth; ids in the frame's tracks are
  /// kept: frame-to-frame odometry.
  void Initialise(const SE3& T_odom_c, TrackedFrame& frame, TrackId& next_id);

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.landmarks_);
  }

 private:
  void Fuse(const SE3& T_odom_c, const StereoPoint& seen, PointLandmark& landmark) const;
  void Age(const SE3& T_c_odom);
  void CreateOne(const SE3& T_odom_c, const StereoPoint& seen, FeatureTrack& track, TrackId& next_id);

  StereoCamera camera_;
  OrbOptions orb_;
  LandmarkOptions options_;
  std::vector<PointLandmark> landmarks_;
};

}  // namespace plslam::vo
