// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/motion/motion_estimator.h"
#include "vo_process/options.h"
#include "vo_process/tracking/tracked_frame.h"
#include "vo_process/tracking/tracker_local_map.h"

namespace plslam::vo {

/// A point that odometry tracks.
struct PointLandmark {
  int64_t id = -1;
  /// Position in the odometry frame, and its covariance given the poses it was seen from.
  Eigen::Vector3d p_odom = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// As last seen.
  Descriptor descriptor{};
  float angle_rad = 0.0F;
  int octave = 0;
  double depth_m = 0.0;

  /// The same landmark in the map, or -1.
  int64_t map_id = -1;
  /// Keyframes that had seen it when the map last told of it.
  int map_observations = 0;
  /// Created by the map, not by a frame.
  bool from_map = false;
  int seen = 1;
  int unseen_frames = 0;
  int missed = 0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.id, self.p_odom, self.covariance, self.descriptor, self.angle_rad, self.octave, self.depth_m, self.map_id,
      self.map_observations, self.from_map, self.seen, self.unseen_frames, self.missed);
  }
};

/// The points in and around the view, each fused over the frames that saw it. Sibling of `LineLandmarks`.
class PointLandmarks {
 public:
  PointLandmarks(const StereoCamera& camera, const OrbOptions& orb, const LandmarkOptions& options)
      : camera_(camera), orb_(orb), options_(options) {}

  const std::vector<PointLandmark>& landmarks() const { return landmarks_; }

  /// Landmarks that should be near the view, by projecting them with the expected pose.
  std::vector<LandmarkMatch> MatchByProjection(const SE3& T_c_odom, const TrackedFrame& frame, const Search& search,
                                               const MatchOptions& options) const;

  /// By descriptors alone, for frames whose pose cannot be predicted.
  std::vector<LandmarkMatch> MatchByDescriptor(const TrackedFrame& frame, int max_unseen_frames,
                                               const MatchOptions& options) const;

  /// What the motion estimator needs of each match.
  std::vector<PointCorrespondence> Observations(const std::vector<LandmarkMatch>& matches,
                                                const TrackedFrame& frame) const;

  /// Fuses what the frame saw of the matched landmarks, names them in the frame's tracks, and ages the others.
  void Update(const SE3& T_odom_c, const std::vector<LandmarkMatch>& matches, TrackedFrame& frame);

  /// Takes over what the map says of landmarks: place and uncertainty of those already here (of several that are the
  /// same the oldest stays), and all of those that are not. With `keep_own` those already here stay where they are.
  void Adopt(const SE3& T_odom_w, const std::vector<Adopted<MapPoint>>& adopted, double map_f_px, bool keep_own,
             int64_t& next_id);

  /// All into another frame, in which `T_new_odom` lies.
  void Move(const SE3& T_new_odom);

  /// All take part in the next search, as if the last frame had seen them.
  void CountAsSeen() {
    for (auto& landmark : landmarks_) landmark.unseen_frames = 0;
  }

  /// Moves those that `taken` flags to a list of their own.
  PointLandmarks Take(const std::vector<char>& taken);

  /// A list of those that `chosen` flags.
  PointLandmarks Copy(const std::vector<char>& chosen) const;

  /// Takes over the landmarks of another list, which lie in the same frame.
  void Append(const PointLandmarks& others);

  /// Founds a landmark for each feature with depth that has none and is on this body (-1: of the world), and names it
  /// in the frame's tracks.
  void Found(const SE3& T_odom_c, TrackedFrame& frame, int64_t& next_id, int body = -1);

  /// The same for every feature of the world with depth, after forgetting all landmarks; names in the frame's tracks
  /// are kept: frame-to-frame odometry.
  void Initialise(const SE3& T_odom_c, TrackedFrame& frame, int64_t& next_id);

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.landmarks_);
  }

 private:
  void Fuse(const SE3& T_odom_c, const StereoPoint& seen, PointLandmark& landmark) const;
  void Age(const SE3& T_c_odom);
  void FoundOne(const SE3& T_odom_c, const StereoPoint& seen, FeatureTrack& track, int64_t& next_id);

  StereoCamera camera_;
  OrbOptions orb_;
  LandmarkOptions options_;
  std::vector<PointLandmark> landmarks_;
};

}  // namespace plslam::vo
