// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"
#include "vo_process/tracking/disparity_calibration.h"
#include "vo_process/tracking/frame_aligner.h"
#include "vo_process/tracking/local_landmarks.h"
#include "vo_process/tracking/tracked_frame.h"

namespace plslam::vo {

// What speaks for a motion that a part of the image shows: how wide the part is, whether its features go the same
// way, and which motion the features around a place follow.

/// Bodies that are told apart at once.
inline constexpr size_t kMaxBodies = 3;

/// How widely what agrees with a motion is spread: cells of the image, of 8 x 6, and octaves of depth, which say more: a
/// body may fill the image, but is seldom as deep as a street.
struct Spread {
  int cells = 0;
  int octaves = 0;
  int Score() const { return cells * octaves * octaves; }
};

Spread SpreadOf(const FrameMatches& matches, const TrackedFrame& frame, const StereoCamera& camera);

/// Matches that went the same way in the image as some that are near by at the same depth: wrong ones go anywhere.
/// `T_c_odom` is where the landmarks were seen from before.
std::vector<LandmarkMatch> MovingTogether(const PointLandmarks& landmarks, const SE3& T_c_odom,
                                          const std::vector<LandmarkMatch>& matches, const TrackedFrame& frame,
                                          const StereoCamera& camera);

/// Features whose motion is known, for asking whose a place in the image is.
class FeaturePlaces {
 public:
  /// Of a body, by its slot, or of the world (-1). A negative disparity is not known.
  void Add(const Eigen::Vector2d& px, double disparity_px, int body) { places_.push_back({px, disparity_px, body}); }

  /// The body that has at least two features around there at about that depth, and more than `times` as many as the
  /// world;
  /// -1: none. A feature at the very place is not counted.
  int Owner(const Eigen::Vector2d& px, double disparity_px, int times) const;

  /// Of a line the body that owns at least two of both ends and the middle.
  int Owner(const StereoLine& line, int times) const;

 private:
  struct Place {
    Eigen::Vector2d px = Eigen::Vector2d::Zero();
    double disparity_px = -1.0;
    int body = -1;
  };

  std::vector<Place> places_;
};

/// Whether an unknown offset of the disparities, within its uncertainty, explains two motions: then points at different
/// depths yield translations of the same direction and different lengths.
bool IsDisparityOffset(const SE3& T_odom_prev, const LocalLandmarks& world, const TrackedFrame& frame,
                       const Alignment& first, const FrameMatches& of_first, const Alignment& second,
                       const DisparityCalibration& calibration, const StereoCamera& camera);

}  // namespace plslam::vo
