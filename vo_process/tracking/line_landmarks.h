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

/// A line segment that odometry tracks.
struct LineLandmark {
  int64_t id = -1;
  /// In the odometry frame, directed as seen (brighter side on the right); covariances of the endpoints given the
  /// poses they were seen from.
  Segment3 segment_odom;
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
  /// As last seen.
  Descriptor descriptor{};

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
    a(self.id, self.segment_odom.p, self.segment_odom.q, self.covariance_p, self.covariance_q, self.descriptor,
      self.map_id, self.map_observations, self.from_map, self.seen, self.unseen_frames, self.missed);
  }
};

/// The line segments in and around the view, each fused over the frames that saw it. Sibling of `PointLandmarks`.
class LineLandmarks {
 public:
  LineLandmarks(const StereoCamera& camera, const LandmarkOptions& options) : camera_(camera), options_(options) {}

  const std::vector<LineLandmark>& landmarks() const { return landmarks_; }

  /// Landmarks that should be near the view, by projecting them with the expected pose.
  std::vector<LandmarkMatch> MatchByProjection(const SE3& T_c_odom, const TrackedFrame& frame, const Search& search,
                                               const LineMatchOptions& options) const;

  /// By descriptors alone, for frames whose pose cannot be predicted.
  std::vector<LandmarkMatch> MatchByDescriptor(const TrackedFrame& frame, int max_unseen_frames,
                                               const LineMatchOptions& options) const;

  /// What the motion estimator needs of each match.
  std::vector<LineCorrespondence> Observations(const std::vector<LandmarkMatch>& matches,
                                               const TrackedFrame& frame) const;

  /// Fuses what the frame saw of the matched landmarks (across the line; along it they are extended), names them in
  /// the frame's tracks, and ages the others.
  void Update(const SE3& T_odom_c, const std::vector<LandmarkMatch>& matches, TrackedFrame& frame);

  /// Takes over what the map says of landmarks: place and uncertainty of those already here (of several that are the
  /// same the oldest stays), and all of those that are not. With `keep_own` those already here stay where they are.
  void Adopt(const SE3& T_odom_w, const std::vector<Adopted<MapLine>>& adopted, bool keep_own, int64_t& next_id);

  /// All into another frame, in which `T_new_odom` lies.
  void Move(const SE3& T_new_odom);

  /// All take part in the next search, as if the last frame had seen them.
  void CountAsSeen() {
    for (auto& landmark : landmarks_) landmark.unseen_frames = 0;
  }

  /// Moves those that `taken` flags to a list of their own.
  LineLandmarks Take(const std::vector<char>& taken);

  /// A list of those that `chosen` flags.
  LineLandmarks Copy(const std::vector<char>& chosen) const;

  /// Takes over the landmarks of another list, which lie in the same frame.
  void Append(const LineLandmarks& others);

  /// Founds a landmark for each segment with depth that has none and is on this body (-1: of the world), and names it
  /// in the frame's tracks.
  void Found(const SE3& T_odom_c, TrackedFrame& frame, int64_t& next_id, int body = -1);

  /// The same for every segment of the world with depth, after forgetting all landmarks; names in the frame's tracks
  /// are kept: frame-to-frame odometry.
  void Initialise(const SE3& T_odom_c, TrackedFrame& frame, int64_t& next_id);

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.landmarks_);
  }

 private:
  void Fuse(const SE3& T_odom_c, const StereoLine& seen, LineLandmark& landmark) const;
  void Age(const SE3& T_c_odom);
  void FoundOne(const SE3& T_odom_c, const StereoLine& seen, FeatureTrack& track, int64_t& next_id);

  StereoCamera camera_;
  LandmarkOptions options_;
  std::vector<LineLandmark> landmarks_;
};

}  // namespace plslam::vo
