// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/map/keyframe.h"
#include "vo_process/options.h"
#include "vo_process/tracking/bodies/motion_evidence.h"
#include "vo_process/tracking/calibration/disparity_calibration.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/landmarks/tracker_local_map.h"
#include "vo_process/tracking/motion/frame_aligner.h"
#include "vo_process/tracking/motion/inertial_motion_model.h"
#include "vo_process/tracking/motion/motion_model.h"

namespace plslam::vo {

/// A rigid object that moves in the world: its landmarks are in a frame of its own, which was the odometry frame when
/// it was found, and the camera moves in that frame as it does in the world.
struct Body {
  Body(const StereoCamera& camera, const VoOptions& options, const std::optional<MountedImu>& imu)
      : landmarks(camera, options), as_world(imu) {}

  bool IsThere() const { return id >= 0; }

  /// Id within the session; -1: the slot is empty.
  int64_t id = -1;
  LocalLandmarks landmarks;
  SE3 T_b_c;
  MotionModel motion;
  /// Middle of its observed landmarks when it was first published.
  Eigen::Vector3d middle_b = Eigen::Vector3d::Zero();
  /// Frames in which it was found, frames since it was last seen, and frames in which it stood while the camera moved.
  int found_frames = 0;
  int unseen_frames = 0;
  int standing_frames = 0;
  /// Frames that must still confirm the choice between it and the world, if only geometry decided it.
  int doubtful_frames = 0;
  /// The inertial sensor, if the body were the world.
  InertialMotionModel as_world;
  /// Twice the logarithm of the ratio of likelihoods, by the sensor, that the body is the world.
  double evidence = 0.0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.id, self.landmarks, self.T_b_c, self.motion, self.middle_b, self.found_frames, self.unseen_frames,
      self.standing_frames, self.doubtful_frames, self.as_world, self.evidence);
  }
};

/// Pose of the camera, and its motion since the previous frame, if a body were the world.
struct RivalMotion {
  SE3 T_odom_c;
  SE3 T_prev_c;
};

/// A body took the place of the world, because the inertial sensor confirms it: its motion, and the sensor in its
/// frame, which is odom from now on.
struct ConfirmedWorld {
  MotionModel motion;
  InertialMotionModel inertial;
};

/// Result of the separation of a frame.
struct Separation {
  /// The other motion, if only geometry decided which is the world's and later frames have not confirmed it.
  std::optional<RivalMotion> rival{};
  std::optional<ConfirmedWorld> confirmed{};
};

/// Pose of a body in a frame: the body's frame is at its middle, with the axes that odometry had when the body was
/// found.
struct BodyPose {
  int64_t id = 0;
  SE3 T_c_body;
  int n_features = 0;
};

/// Landmarks on bodies: their ids in the tracker and, if known, in the map.
class OwnedIds {
 public:
  void Add(TrackId id, LandmarkId map_id) {
    const bool is_new = Insert(id, ids_);
    if (Insert(map_id, map_ids_) || is_new) new_.push_back({id, map_id});
  }
  void Remove(TrackId id, LandmarkId map_id) {
    Erase(id, ids_);
    Erase(map_id, map_ids_);
    std::erase_if(new_, [id](const Withdrawn& landmark) { return landmark.landmark_id == id; });
  }
  bool Has(TrackId id) const { return std::binary_search(ids_.begin(), ids_.end(), id); }
  bool HasOfMap(LandmarkId map_id) const { return std::binary_search(map_ids_.begin(), map_ids_.end(), map_id); }
  /// Removes landmarks on bodies from adopted landmarks of the map, and learns their ids in the map.
  template <class Landmark>
  void LeaveOut(std::vector<Adopted<Landmark>>& adopted) {
    std::erase_if(adopted, [this](const Adopted<Landmark>& entry) {
      const auto& ids = entry.tracker_ids;
      const auto on_body = std::find_if(ids.begin(), ids.end(), [this](TrackId id) { return Has(id); });
      const bool is_owned = on_body != ids.end() || HasOfMap(entry.landmark->id);
      if (on_body != ids.end()) Add(*on_body, entry.landmark->id);
      return is_owned;
    });
  }
  /// Returns those added since the last call.
  std::vector<Withdrawn> TakeNew() { return std::exchange(new_, {}); }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.ids_, self.map_ids_, self.new_);
  }

 private:
  // The oldest are removed first; the tracker has dropped these landmarks.
  static constexpr size_t kMaxIds = 20'000;

  template <class AnId>
  static bool Insert(AnId id, std::vector<AnId>& ids) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), id);
    if (id < 0 || (place != ids.end() && *place == id)) return false;
    ids.insert(place, id);
    if (ids.size() > kMaxIds) ids.erase(ids.begin());
    return true;
  }
  template <class AnId>
  static void Erase(AnId id, std::vector<AnId>& ids) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), id);
    if (place != ids.end() && *place == id) ids.erase(place);
  }

  /// Ascending.
  std::vector<TrackId> ids_;
  std::vector<LandmarkId> map_ids_;
  std::vector<Withdrawn> new_;
};

/// The bodies in view, up to three.
///
/// A second consensus is searched among the features that contradict the pose found for a frame. The world's motion is
/// the one of the two that was not a body's before, that the inertial sensor confirms, that continues the predicted
/// motion, or, if that does not decide, that is spread over more of the image and more depths; never merely the one with
/// more features. Features on a body, or nearer to it than to the world at the same depth, create landmarks of that body.
/// A body that stands while the camera moves returns to the world. (Label persistence as in Multimotion Visual Odometry,
/// Judd, Gammell and Newman 2018; choosing the world by prediction and inertial sensor instead of size is ours.)
///
/// With an inertial sensor the choice is reviewed: the poses by the world and by each body are compared with the samples,
/// frame after frame, and a body that agrees so much better that the sensor confirms it and contradicts the world takes
/// the world's place. No sensor distinguishes a body that neither turns nor accelerates from the world.
class MovingBodies {
 public:
  MovingBodies(const StereoCamera& camera, const VoOptions& options, const std::optional<MountedImu>& imu);

  /// Separates bodies from the world in a frame that was aligned at `found`. Corrects `found` if it was a body's
  /// motion, or if features of a body took part; moves the landmarks of bodies out of `world`; sets the body in the
  /// frame's tracks. Two motions that an unknown disparity offset explains count as one. If a body takes the world's
  /// place, `found` is its pose, and does not continue `T_odom_prev`.
  Separation Separate(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
                      const DisparityCalibration& calibration, const InertialMotionModel& inertial,
                      LocalLandmarks& world, TrackedFrame& frame, Alignment& found);

  /// The same for a frame that was found at an unexpected pose: the motion since the previous frame is unknown, so
  /// known bodies are followed and no others are searched.
  void SeparateKnown(double dt_s, const InertialMotionModel& inertial, LocalLandmarks& world, TrackedFrame& frame,
                     Alignment& found);

  /// Follows bodies in a lost frame, the `n_lost`th in a row, so that their landmarks do not start a new world. Forgets
  /// them after some frames, and if one of them may be the world.
  void FollowWhileLost(int n_lost, double dt_s, const InertialMotionModel& inertial, LocalLandmarks& world,
                       TrackedFrame& frame);

  /// Discards all bodies.
  void Forget();

  /// Whether there are bodies now, seen or not, published or not yet.
  bool IsAnyThere() const {
    return std::any_of(bodies_.begin(), bodies_.end(), [](const Body& body) { return body.IsThere(); });
  }

  /// Bodies published in the session so far, and features of the frame on such a body.
  int64_t n_met() const { return n_met_; }
  int CountFeatures(const TrackedFrame& frame) const;
  /// Returns the poses of published bodies that the last frame shows.
  std::vector<BodyPose> Poses() const;

  /// Removes landmarks on bodies from a local map; the map received them before they were recognised as such.
  void LeaveOut(TrackerLocalMap& local_map);

  /// Return the landmarks assigned to bodies since the last call.
  std::vector<Withdrawn> TakeWithdrawnPoints() { return owned_points_.TakeNew(); }
  std::vector<Withdrawn> TakeWithdrawnLines() { return owned_lines_.TakeNew(); }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    for (auto& body : self.bodies_) a(body);
    a(self.is_first_pair_, self.next_body_id_, self.n_met_, self.owned_points_, self.owned_lines_);
  }

 private:
  /// Least exclusive inliers (points + 2 x lines) of a second motion.
  static constexpr int kMinWeight = 25;
  /// Frames in which a body must be found before it is published; parts found one by one have been joined by then.
  static constexpr int kMetFrames = 5;

  /// Features that are already associated.
  struct Claims {
    std::vector<char> points;
    std::vector<char> lines;
  };
  /// The unassociated features of a frame, as a frame of their own.
  struct Rest;

  bool AnyIsThere() const;
  /// Follows known bodies among the features that are not matched with the world.
  Claims Follow(double dt_s, const InertialMotionModel& inertial, const TrackedFrame& frame,
                const Alignment& of_world);
  /// Compares the poses by the world and by each body with the inertial sensor. Returns the body that is the world.
  std::optional<size_t> CompareWithSensor(const InertialMotionModel& inertial, const Alignment& found);
  ConfirmedWorld Exchange(size_t k, const SE3& T_odom_prev, double dt_s, const InertialMotionModel& inertial,
                          LocalLandmarks& world, Alignment& found);
  void JoinParts(size_t first, size_t second, const TrackedFrame& frame);
  bool FindNew(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
               const DisparityCalibration& calibration, const InertialMotionModel& inertial, LocalLandmarks& world,
               const TrackedFrame& frame, Claims& claims, Alignment& found);
  std::optional<RivalMotion> FindRival(const FrameMatches& of_world, const TrackedFrame& frame);
  /// Finds a second motion: matches of landmarks of the world with features of the frame, all of which contradict the
  /// first.
  std::optional<Alignment> FindSecond(const SE3& T_odom_prev, const MotionPrediction& prediction,
                                      const LocalLandmarks& world, const TrackedFrame& frame, const Claims& claims,
                                      const Alignment& found) const;
  int BodyAround(const FrameMatches& matches, const FrameMatches& of_world, const TrackedFrame& frame) const;
  bool Join(int known, const SE3& T_odom_prev, const LocalLandmarks& taken, const FrameMatches& matches,
            const TrackedFrame& frame);
  FrameMatches Contradicting(const LocalLandmarks& landmarks, const TrackedFrame& frame, const FrameMatches& matches,
                             const SE3& T_odom_c) const;
  bool IsWorld(const Alignment& found, const FrameMatches& own, const Alignment& second, const SE3& T_odom_prev,
               const MotionPrediction& prediction, const InertialMotionModel& inertial, const TrackedFrame& frame,
               bool& guessed) const;
  void AssignToBodies(const LocalLandmarks& world, const TrackedFrame& frame, const FeaturePlaces& places,
                      Alignment& found) const;
  void NameFeatures(const FeaturePlaces& places, const FrameMatches& of_world, TrackedFrame& frame) const;
  void CreateLandmarksOnBodies(LocalLandmarks& world, TrackedFrame& frame);
  void ReleaseStandingBodies(const SE3& T_odom_prev, const SE3& T_odom_c, LocalLandmarks& world, TrackedFrame& frame);
  void ReturnToWorld(size_t k, const SE3& T_odom_c, LocalLandmarks& world, TrackedFrame& frame);
  FeaturePlaces AllPlaces(const FrameMatches& of_world, const TrackedFrame& frame) const;
  void Own(const LocalLandmarks& landmarks);

  StereoCamera camera_;
  FrameAligner aligner_;
  /// One for each slot; `FeatureTrack::body` is an index into it.
  std::vector<Body> bodies_;
  /// Matches, pose of the previous camera in the body's frame, and covariance of the pose, for the current frame, by
  /// slot.
  std::vector<FrameMatches> matches_;
  std::vector<SE3> T_b_prev_;
  std::vector<Matrix6d> covariances_;
  /// Agreement of the inertial sensor with the pose of the current frame, before the sensor's model observed it, by
  /// slot.
  std::vector<std::optional<InertialFilter::Agreement>> agreements_;
  /// The same, as if the pose and the world's were equally accurate: with the sum of their covariances.
  std::vector<std::optional<InertialFilter::Agreement>> equal_agreements_;
  bool is_first_pair_ = true;
  int64_t next_body_id_ = 0;
  int64_t n_met_ = 0;
  OwnedIds owned_points_;
  OwnedIds owned_lines_;
};

}  // namespace plslam::vo
