// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"
#include "vo_process/tracking/calibration/disparity_calibration.h"
#include "vo_process/tracking/landmarks/local_landmarks.h"
#include "vo_process/tracking/landmarks/tracked_frame.h"
#include "vo_process/tracking/motion/frame_aligner.h"
#include "vo_process/tracking/motion/motion_model.h"

namespace plslam::vo {

// Evidence for a motion of a part of the image: its extent, the consistency of its features, and the motion of the
// features around a position.

/// Largest number of bodies tracked at once.
inline constexpr size_t kMaxBodies = 3;

/// Extent of the inliers of a motion: cells of the image, of 8 x 6, and octaves of depth. Depth counts more, because a
/// body may fill the image, but is seldom as deep as a street.
struct Spread {
  int cells = 0;
  int octaves = 0;
  int Score() const { return cells * octaves * octaves; }
};

Spread SpreadOf(const FrameMatches& matches, const TrackedFrame& frame, const StereoCamera& camera);

/// Returns the matches that moved in the image like some neighbours at the same depth: wrong matches move randomly.
/// `T_c_odom` is the previous pose, from which the landmarks were observed.
std::vector<LandmarkMatch> MovingTogether(const PointLandmarks& landmarks, const SE3& T_c_odom,
                                          const std::vector<LandmarkMatch>& matches, const TrackedFrame& frame,
                                          const StereoCamera& camera);

/// Features with known motion, to find the owner of a position in the image.
class FeaturePlaces {
 public:
  /// Adds a feature of a body (its slot) or of the world (-1). A negative disparity is unknown.
  void Add(const Eigen::Vector2d& px, double disparity_px, int body) { places_.push_back({px, disparity_px, body}); }

  /// Returns the body that has at least two features around the position at about that depth, and more than `times` as
  /// many as the world; -1 if there is none. A feature at exactly the position does not count.
  int Owner(const Eigen::Vector2d& px, double disparity_px, int times) const;

  /// Returns the body that owns at least two of the ends and the middle of a line; -1 if there is none.
  int Owner(const StereoLine& line, int times) const;

 private:
  struct Place {
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double disparity_px = -1.0;
    int body = -1;
  };

  std::vector<Place> places_;
};

/// Whether a pose continues the predicted motion.
bool IsExpected(const SE3& T_odom_c, const SE3& T_odom_prev, const MotionPrediction& prediction);

/// Whether an unknown offset of the disparities, within its uncertainty, explains two motions: points at different
/// depths then give translations in the same direction with different lengths.
bool IsDisparityOffset(const SE3& T_odom_prev, const LocalLandmarks& world, const TrackedFrame& frame,
                       const Alignment& first, const FrameMatches& of_first, const Alignment& second,
                       const DisparityCalibration& calibration, const StereoCamera& camera);

}  // namespace plslam::vo
