// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "core/config/choices.h"
#include "core/config/fields.h"
#include "core/features/options.h"
#include "core/motion/options.h"

namespace plslam::vo {

/// Creation and removal of the landmarks that odometry tracks.
struct LandmarkOptions {
  /// Model error of lines (edges are not perfectly straight), added to the sigma of their fit.
  double line_model_sigma_px = 0.1;
  /// Largest factor of the sigmas of points if lines show that they are too small; 1 disables it.
  double max_point_scale = 16.0;
  /// Largest relative sigma of a disparity for a new landmark.
  double max_relative_depth_sigma = 0.3;
  /// Growth of a landmark's covariance before each new observation of it.
  double forgetting = 1.02;
  /// Frames out of view after which a landmark is dropped.
  int max_unseen_frames = 30;
  /// Frames in view but not matched after which it is dropped.
  int max_missed = 8;
};

/// Self-calibration of the disparities.
struct DisparityCalibrationOptions {
  bool enabled = true;
  /// Prior sigma of the offset; wide, because a narrow one delays large offsets. `DisparityCheck` decides.
  double prior_sigma_px = 1.0;
  /// Evidence (3 degrees of freedom) above which an offset is significant.
  double min_chi_square = 25.0;
};

/// Self-calibration of the vertical disparity.
struct RowCalibrationOptions {
  bool enabled = true;
  /// Prior sigma of each coefficient.
  double prior_sigma_px = 0.5;
  /// Evidence (6 degrees of freedom) above which they are applied.
  double min_chi_square = 40.0;
  /// Norm of the coefficients above which they are applied.
  double min_offset_px = 0.5;
};

/// Row of an image that time stamps, and so poses, refer to.
enum class StampRow { kFirst, kMiddle, kLast };
constexpr auto ChoicesOf(StampRow) {
  return std::array{Choice{"first", StampRow::kFirst}, Choice{"middle", StampRow::kMiddle},
                    Choice{"last", StampRow::kLast}};
}

/// Cameras that read their rows one after the other (`readout_ms` of the calibration).
struct RollingShutterOptions {
  StampRow stamp = StampRow::kFirst;
};

/// Origin of the positions that frames are aligned to: landmarks fused over frames, or the previous frame alone, as in
/// the paper.
enum class TrackingReference { kLandmarks, kPreviousFrame };
constexpr auto ChoicesOf(TrackingReference) {
  return std::array{Choice{"landmarks", TrackingReference::kLandmarks},
                    Choice{"previous_frame", TrackingReference::kPreviousFrame}};
}

/// Features of a frame: all detected again, as in the paper, or followed from the last frame where that suffices.
enum class FrontEnd { kDescriptors, kSemiDirect };
constexpr auto ChoicesOf(FrontEnd) {
  return std::array{Choice{"descriptors", FrontEnd::kDescriptors}, Choice{"semi_direct", FrontEnd::kSemiDirect}};
}

/// Matching of landmarks with a frame, and conditions of a tracked frame.
struct TrackingOptions {
  TrackingReference reference = TrackingReference::kLandmarks;
  FrontEnd front_end = FrontEnd::kSemiDirect;
  /// Radius of the search around predictions.
  double search_radius_px = 18.0;
  /// The same if the first search fails.
  double wide_radius_px = 70.0;
  /// The same once the pose is known.
  double refine_radius_px = 6.0;
  int min_inliers = 10;
  int weak_inliers = 25;
  /// Share of matches that must agree with the motion.
  double min_inlier_ratio = 0.3;
  /// Share of the last frame's inliers below which wider searches are tried, too.
  double accepted_ratio = 0.7;
  /// Ratio to the inliers at an expected pose above which an unexpected pose is accepted instead.
  double elsewhere_ratio = 1.5;
};

/// Use of the map of mapping_process.
struct MapUseOptions {
  bool enabled = true;
  int local_keyframes = 20;
  bool localise_only = false;
};

/// Masks of single frames from another program (channel MASK).
struct MaskUseOptions {
  bool enabled = false;
  double live_wait_ms = 20.0;
};

/// The robot's own odometry (channel ROBOT_MOTION).
struct RobotMotionUseOptions {
  bool enabled = false;
};

/// The inertial sensor (channel IMU), if the rig has one.
struct ImuUseOptions {
  bool enabled = true;
  double live_wait_ms = 20.0;
};

/// Relocalisation in the map by loop_process.
struct RelocalisationUseOptions {
  bool enabled = true;
};

/// Keyframe selection (PL-SLAM §IV.D) and its floors.
struct KeyframeOptions {
  double entropy_ratio = 0.9;
  /// A keyframe is made below this share of the last one's tracked landmarks.
  double min_tracked_ratio = 0.45;
  /// Least translation for a keyframe, relative to the median depth.
  double min_baseline_ratio = 0.02;
  double max_baseline_ratio = 0.15;
  /// Least rotation for a keyframe.
  double min_rotation_deg = 2.0;
  double max_rotation_deg = 15.0;
  int max_frames = 40;
  double known_share = 0.5;
  /// Number of keyframes that observe a well-known landmark.
  int known_observations = 6;
};

/// All options of vo_process.
struct VoOptions {
  FeatureOptions features;
  StereoOptions stereo;
  MatchOptions point_matching;
  LineMatchOptions line_matching;
  MotionOptions motion;
  DisparityCalibrationOptions disparity_calibration;
  RowCalibrationOptions row_calibration;
  RollingShutterOptions rolling_shutter;
  LandmarkOptions landmarks;
  TrackingOptions tracking;
  MaskUseOptions masks;
  RobotMotionUseOptions robot_motion;
  ImuUseOptions imu;
  MapUseOptions map;
  RelocalisationUseOptions relocalisation;
  KeyframeOptions keyframes;
  /// File of the state; empty: none.
  std::string state_file;
  /// File of the self-calibration, for the next run.
  std::string self_calibration_file;
};

template <class Visitor>
void VisitFields(Visitor& visit, DisparityCalibrationOptions& o) {
  visit("enabled", o.enabled, "estimate the offset of the disparities and correct for it");
}

template <class Visitor>
void VisitFields(Visitor& visit, RowCalibrationOptions& o) {
  visit("enabled", o.enabled, "estimate the vertical disparity and correct for it");
}

template <class Visitor>
void VisitFields(Visitor& visit, RollingShutterOptions& o) {
  visit("stamp", o.stamp, "row of the images that their time stamps, and so the poses, refer to");
}

template <class Visitor>
void VisitFields(Visitor& visit, TrackingOptions& o) {
  visit("reference", o.reference,
        "landmarks: positions fused over frames; previous_frame: frame to frame, as in the paper");
  visit(
      "front_end", o.front_end,
      "semi_direct: features are followed by their grey levels where that suffices; descriptors: all are detected in "
      "each frame, as in the paper");
  visit("min_inliers", o.min_inliers, Bounds{3, 1000}, "inliers (points + 2 x lines) below which a frame is lost");
  visit("weak_inliers", o.weak_inliers, Bounds{3, 1000}, "the same below which tracking is weak and the prior helps");
}

template <class Visitor>
void VisitFields(Visitor& visit, MapUseOptions& o) {
  visit("enabled", o.enabled, "track frames against the map as well");
  visit("local_keyframes", o.local_keyframes, Bounds{1, 10000},
        "keyframes of the local map, whose landmarks are searched in each frame");
  visit("localise_only", o.localise_only,
        "localise in a fixed map: publish no keyframes; valid until mapping_process publishes "
        "its own setting");
}

template <class Visitor>
void VisitFields(Visitor& visit, MaskUseOptions& o) {
  visit("enabled", o.enabled, "wait for the masks of each frame, which another program publishes");
  visit("live_wait_ms", o.live_wait_ms, Bounds{0, 1000}, "how long a frame waits in real time");
}

template <class Visitor>
void VisitFields(Visitor& visit, RobotMotionUseOptions& o) {
  visit("enabled", o.enabled, "predict the motion from the robot's odometry, published by adapter");
}

template <class Visitor>
void VisitFields(Visitor& visit, ImuUseOptions& o) {
  visit("enabled", o.enabled, "use the inertial sensor of the rig, if it has one");
  visit("live_wait_ms", o.live_wait_ms, Bounds{0, 1000}, "how long a frame waits in real time");
}

template <class Visitor>
void VisitFields(Visitor& visit, RelocalisationUseOptions& o) {
  visit("enabled", o.enabled, "ask loop_process for the pose when tracking is lost");
}

template <class Visitor>
void VisitFields(Visitor& visit, KeyframeOptions& o) {
  visit("entropy_ratio", o.entropy_ratio, Bounds{0, 1}, "a keyframe is made when the entropy ratio falls below this");
  visit("max_baseline_ratio", o.max_baseline_ratio, Bounds{0, 10},
        "a keyframe is made after a translation of this fraction of the median depth");
  visit("max_rotation_deg", o.max_rotation_deg, Bounds{0, 180}, "a keyframe is made after this rotation");
  visit("max_frames", o.max_frames, Bounds{1, 100000},
        "a keyframe is made after this many frames if the camera has moved");
  visit("known_share", o.known_share, Bounds{0, 1.01},
        "if more than this share of the tracked landmarks is well observed in the map, translation, rotation and age "
        "make no keyframe; above 1: they always do");
}

template <class Visitor>
void VisitFields(Visitor& visit, VoOptions& o) {
  visit("features", o.features, "detected features");
  visit("stereo", o.stereo, "stereo matching");
  visit("motion", o.motion, "motion estimation");
  visit("disparity_calibration", o.disparity_calibration, "self-calibration of the disparities");
  visit("row_calibration", o.row_calibration, "self-calibration of the rows of the right image");
  visit("rolling_shutter", o.rolling_shutter, "cameras whose calibration states readout_ms");
  visit("tracking", o.tracking, "landmark search, and when a frame counts as tracked");
  visit("masks", o.masks, "masks of single frames");
  visit("robot_motion", o.robot_motion, "prediction by the robot's own odometry");
  visit("imu", o.imu, "the inertial sensor");
  visit("map", o.map, "use of the map");
  visit("relocalisation", o.relocalisation, "relocalisation after a loss");
  visit("keyframes", o.keyframes, "choice of keyframes");
  visit("self_calibration_file", o.self_calibration_file,
        "file of the self-calibration, for later runs with the same calibration; empty: "
        "nowhere");
  visit("state_file", o.state_file,
        "file of the process state, read after a crash; must be removed after the run; empty: "
        "none");
}

}  // namespace plslam::vo
