// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <variant>

#include "core/geometry/stereo_camera.h"
#include "vo_process/options.h"
#include "vo_process/tracking/bodies/moving_bodies.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/landmarks/tracker_local_map.h"
#include "vo_process/tracking/motion/frame_aligner.h"
#include "vo_process/tracking/motion/motion_model.h"

namespace plslam::vo {

/// Landmarks among which a frame was found: usually those of the previous frame; after a loss those of the previous
/// local map, those of the map at the relocalised place, or those created by a lost frame, or while the inertial sensor
/// carried the pose. A camera that was not lost is localised: found among both, and continues with those of the map; or
/// the landmarks of a body turn out to be the world's (`MovingBodies`).
enum class Reference {
  kCurrent,
  kPreviousLocalMap,
  kRelocalised,
  kLocalised,
  kCreatedWhileLost,
  kCreatedWhileCarried,
  kConfirmedBody
};

/// A frame that was found.
struct Tracked {
  Alignment alignment;
  Reference reference = Reference::kCurrent;
  /// kPreviousLocalMap: the last pose among these landmarks, and its time before the last frame.
  SE3 T_odom_before{};
  double before_s = 0.0;
  /// kRelocalised, kLocalised: pose of odom in the map.
  std::optional<SE3> T_w_odom{};
  /// The pose by the other motion, if only geometry decided which of two is the world's.
  std::optional<RivalMotion> rival{};
  /// The pose by features alone.
  InertialMotionModel::MeasuredPose seen{};
  /// kConfirmedBody.
  std::optional<ConfirmedWorld> confirmed{};
  /// Whether no velocity was known before.
  bool is_first_motion = false;

  /// Whether the pose continues those before, as far as is known without it.
  bool ContinuesMotion() const {
    return reference == Reference::kCurrent || reference == Reference::kLocalised ||
           reference == Reference::kCreatedWhileCarried;
  }
  /// Whether the difference to the previous pose is no motion.
  bool Jumped() const {
    return reference == Reference::kPreviousLocalMap || reference == Reference::kRelocalised ||
           reference == Reference::kConfirmedBody;
  }
  /// Whether the landmarks were created at the previous pose, and are exact relative to it.
  bool IsExactBefore() const {
    return reference == Reference::kCreatedWhileLost || reference == Reference::kCreatedWhileCarried ||
           reference == Reference::kRelocalised;
  }
};

/// Finds frames among landmarks, also after frames that were not found.
///
/// States: `Tracking`, until a frame is not found; `Carried`, while the inertial sensor replaces the pose; `Lost`. A
/// frame that is found ends the last two. A relocalisation may come in any state, and concerns the next frame.
class Recovery {
 public:
  /// A frame, the pose of the previous one and the predicted motion since.
  struct Query {
    const TrackedFrame& frame;
    const SE3& T_odom_prev;
    const MotionPrediction& prediction;
    bool knows_motion = false;  ///< as in `MotionModel`
  };

  Recovery(const StereoCamera& camera, const VoOptions& options)
      : camera_(camera), options_(options), aligner_(camera, options) {}

  bool is_lost() const { return std::holds_alternative<Lost>(state_); }

  /// Returns nullopt if the frame is not found; `Carry` or `Miss` must follow. `landmarks` become those among which it
  /// was found.
  std::optional<Tracked> Find(const Query& query, LocalLandmarks& landmarks);

  /// Sets the inlier score of a frame that was found (points + 2 x lines), which the next one should reach.
  void Expect(int inlier_score);

  /// The pose of a frame is carried. Returns the number of such frames in a row.
  int Carry();
  /// The carried frame has created landmarks.
  void CreatedWhileCarried();

  /// The frame is lost, `dt_s` after the previous one, which was at `T_odom_prev` among `landmarks`. `by_robot`: its
  /// motion was predicted by other sensors. Returns the number of lost frames in a row.
  int Miss(const SE3& T_odom_prev, double dt_s, bool by_robot, const LocalLandmarks& landmarks);

  /// Adopts landmarks of the map; while the camera is lost, they belong to the previous local map.
  void Adopt(const TrackerLocalMap& local_map, LocalLandmarks& landmarks);

  /// Searches the next frame also among the landmarks of the map around a relocalisation result.
  void Relocalise(const TrackerLocalMap& local_map, LocalLandmarks& landmarks);

  /// The state after a frame that was tracked, for `core/files/archive.h`: `Tracking`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.tracked_weight_);
  }

 private:
  struct Tracking {};
  struct Carried {
    int n_frames = 0;
    bool created_landmarks = false;
  };
  /// The previous local map: the landmarks before the loss, and the last pose among them.
  struct Lost {
    LocalLandmarks landmarks;
    SE3 T_odom_c;
    int n_frames = 0;        ///< since the loss
    double elapsed_s = 0.0;  ///< time from the loss to the last frame
    bool by_robot = true;    ///< whether other sensors cover all of these frames
  };
  /// Landmarks of the map around a relocalisation result.
  struct Relocalised {
    LocalLandmarks landmarks;
    SE3 T_w_odom;
  };

  std::optional<Tracked> FindInPreviousLocalMap(const Query& query, LocalLandmarks& landmarks);
  std::optional<Tracked> FindRelocalised(const Query& query, LocalLandmarks& landmarks);
  std::optional<Tracked> FindCurrent(const Query& query, const LocalLandmarks& landmarks) const;
  bool KeepOdometry(const Query& query, const LocalLandmarks& landmarks, Alignment& found, Relocalised& place) const;
  std::optional<Alignment> Align(const Query& query, const LocalLandmarks& landmarks, const SE3& T_odom_prev) const;

  StereoCamera camera_;
  VoOptions options_;
  FrameAligner aligner_;
  std::variant<Tracking, Carried, Lost> state_;
  std::optional<Relocalised> relocalised_;
  /// Inlier score of the last tracked frame.
  int tracked_weight_ = 0;
};

}  // namespace plslam::vo
