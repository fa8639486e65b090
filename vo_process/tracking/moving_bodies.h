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
#include "vo_process/tracking/disparity_calibration.h"
#include "vo_process/tracking/frame_aligner.h"
#include "vo_process/tracking/local_landmarks.h"
#include "vo_process/tracking/motion_evidence.h"
#include "vo_process/tracking/motion_model.h"
#include "vo_process/tracking/tracker_local_map.h"

namespace plslam::vo {

/// A rigid thing that moves through the world: its landmarks lie in a frame of its own, which was the odometry frame
/// when it was found, and the camera moves in that frame as it does in the world.
struct Body {
  Body(const StereoCamera& camera, const VoOptions& options) : landmarks(camera, options), motion(options.tracking) {}

  bool IsThere() const { return id >= 0; }

  /// Numbers the bodies of a session; -1: nothing here.
  int64_t id = -1;
  LocalLandmarks landmarks;
  SE3 T_b_c;
  MotionModel motion;
  /// The middle of what was seen of it when it was told of first.
  Eigen::Vector3d middle_b = Eigen::Vector3d::Zero();
  /// Frames it was found in, those since it was seen last, and for how many it has stood while the camera moved.
  int found_frames = 0;
  int unseen_frames = 0;
  int standing_frames = 0;
  /// The choice between it and the world was one of geometry alone: frames that must yet confirm it.
  int doubtful_frames = 0;

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.id, self.landmarks, self.T_b_c, self.motion, self.middle_b, self.found_frames, self.unseen_frames,
      self.standing_frames, self.doubtful_frames);
  }
};

/// Where the camera would be, and how it would have moved since the frame before, if a body were the world.
struct RivalMotion {
  SE3 T_odom_c;
  SE3 T_prev_c;
};

/// Where a body is in a frame: a frame of its own in the middle of it, with the axes that odometry had when the body was
/// first told of.
struct BodyPose {
  int64_t id = 0;
  SE3 T_c_body;
  int n_features = 0;
};

/// Landmarks that bodies have taken: their numbers in the tracker and, where known, in the map.
class OwnedIds {
 public:
  void Add(int64_t id, int64_t map_id) {
    const bool is_new = Insert(id, ids_);
    if (Insert(map_id, map_ids_) || is_new) new_.push_back({id, map_id});
  }
  void Remove(int64_t id, int64_t map_id) {
    Erase(id, ids_);
    Erase(map_id, map_ids_);
  }
  bool Has(int64_t id) const { return std::binary_search(ids_.begin(), ids_.end(), id); }
  bool HasOfMap(int64_t map_id) const { return std::binary_search(map_ids_.begin(), map_ids_.end(), map_id); }
  /// Takes them out of what the map tells, and learns their numbers in the map.
  template <class Landmark>
  void LeaveOut(std::vector<Adopted<Landmark>>& adopted) {
    std::erase_if(adopted, [this](const Adopted<Landmark>& entry) {
      const auto& ids = entry.tracker_ids;
      const auto on_body = std::find_if(ids.begin(), ids.end(), [this](int64_t id) { return Has(id); });
      const bool is_owned = on_body != ids.end() || HasOfMap(entry.landmark->id);
      if (on_body != ids.end()) Add(*on_body, entry.landmark->id);
      return is_owned;
    });
  }
  /// Those added since this was asked last.
  std::vector<Withdrawn> TakeNew() { return std::exchange(new_, {}); }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.ids_, self.map_ids_, self.new_);
  }

 private:
  // The oldest give way: the tracker has long dropped them.
  static constexpr size_t kMaxIds = 20'000;

  static bool Insert(int64_t id, std::vector<int64_t>& ids) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), id);
    if (id < 0 || (place != ids.end() && *place == id)) return false;
    ids.insert(place, id);
    if (ids.size() > kMaxIds) ids.erase(ids.begin());
    return true;
  }
  static void Erase(int64_t id, std::vector<int64_t>& ids) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), id);
    if (place != ids.end() && *place == id) ids.erase(place);
  }

  /// Ascending.
  std::vector<int64_t> ids_;
  std::vector<int64_t> map_ids_;
  std::vector<Withdrawn> new_;
};

/// The bodies in view, up to three.
///
/// A second consensus is looked for among what contradicts the pose found for a frame. Of two motions the world is
/// the one that a body has not had before, that the motion so far goes on with, and, where that says nothing, the one
/// that is spread over more of the image and more depths; never the one that merely has more features. What is on a
/// body, or nearer to it than to the world at the same depth, creates landmarks of that body. One that stands while
/// the camera moves goes back to the world. (Label persistence as in Multimotion Visual Odometry, Judd, Gammell and
/// Newman 2018; the choice of the world by prediction instead of size is ours.)
class MovingBodies {
 public:
  MovingBodies(const StereoCamera& camera, const VoOptions& options);

  /// Tells bodies and world apart in a frame that was found at `found`. Changes `found` where it was a body's motion,
  /// or where features of a body took part in it; takes the landmarks of bodies out of `world`; names in the frame's
  /// tracks what is on a body. Where only geometry decided which motion is the world's, and it is not yet clear that it
  /// decided rightly: the other one.
  /// Two motions that an unknown offset of the disparities explains are one.
  std::optional<RivalMotion> Separate(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
                                      const DisparityCalibration& calibration, LocalLandmarks& world,
                                      TrackedFrame& frame, Alignment& found);

  /// The same of a frame that was found elsewhere than it was thought to be: the motion since the frame before is not
  /// known, so bodies that are known go on, and no others are looked for.
  void SeparateKnown(double dt_s, LocalLandmarks& world, TrackedFrame& frame, Alignment& found);

  /// Of a frame that was not found, the `n_lost`th in a row: bodies go on, so that their landmarks are not taken for a
  /// new world. Not for long, and not where one of them may be the world.
  void FollowWhileLost(int n_lost, double dt_s, LocalLandmarks& world, TrackedFrame& frame);

  /// Nobody knows where bodies are.
  void Forget();

  /// Bodies that the session has met so far, and features of the frame that are on one.
  int64_t n_met() const { return n_met_; }
  int CountFeatures(const TrackedFrame& frame) const;
  /// Those of the bodies met that the last frame shows.
  std::vector<BodyPose> Poses() const;

  /// Leaves out of what the map tells the landmarks that are on bodies; the map has them from before that was known.
  void LeaveOut(TrackerLocalMap& local_map);

  /// Landmarks that bodies have taken since this was asked last.
  std::vector<Withdrawn> TakeWithdrawnPoints() { return owned_points_.TakeNew(); }
  std::vector<Withdrawn> TakeWithdrawnLines() { return owned_lines_.TakeNew(); }

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    for (auto& body : self.bodies_) a(body);
    a(self.is_first_pair_, self.next_body_id_, self.n_met_, self.owned_points_, self.owned_lines_);
  }

 private:
  /// Features that somebody has claimed.
  struct Claims {
    std::vector<char> points;
    std::vector<char> lines;
  };
  /// The features of a frame that nobody has claimed, as a frame of their own.
  struct Rest;

  bool AnyIsThere() const;
  /// Bodies that are known, among the features that are not among these matches of the world.
  Claims Follow(double dt_s, const TrackedFrame& frame, const FrameMatches& of_world);
  void JoinParts(size_t first, size_t second, const TrackedFrame& frame);
  bool FindNew(const SE3& T_odom_prev, const MotionPrediction& prediction, double dt_s,
               const DisparityCalibration& calibration, LocalLandmarks& world, const TrackedFrame& frame,
               Claims& claims, Alignment& found);
  std::optional<RivalMotion> FindRival(const FrameMatches& of_world, const TrackedFrame& frame);
  /// A second motion: matches of landmarks of the world with features of the frame, all of which contradict the
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
               const MotionPrediction& prediction, const TrackedFrame& frame, bool& guessed) const;
  void GiveToBodies(const LocalLandmarks& world, const TrackedFrame& frame, const FeaturePlaces& places,
                    Alignment& found) const;
  void NameFeatures(const FeaturePlaces& places, const FrameMatches& of_world, TrackedFrame& frame) const;
  void FoundOnBodies(LocalLandmarks& world, TrackedFrame& frame);
  void LetStandingGo(const SE3& T_odom_prev, const SE3& T_odom_c, LocalLandmarks& world, TrackedFrame& frame);
  void GiveBack(size_t k, const SE3& T_odom_c, LocalLandmarks& world, TrackedFrame& frame);
  FeaturePlaces AllPlaces(const FrameMatches& of_world, const TrackedFrame& frame) const;
  void Own(const LocalLandmarks& landmarks);

  StereoCamera camera_;
  FrameAligner aligner_;
  /// One for each slot; `FeatureTrack::body` is the place here.
  std::vector<Body> bodies_;
  /// Of the frame at hand, by slot.
  std::vector<FrameMatches> matches_;
  std::vector<SE3> T_b_prev_;
  bool is_first_pair_ = true;
  int64_t next_body_id_ = 0;
  int64_t n_met_ = 0;
  OwnedIds owned_points_;
  OwnedIds owned_lines_;
};

}  // namespace plslam::vo
