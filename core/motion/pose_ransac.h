#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/motion/motion_estimator.h"

namespace plslam {

/// Pose without a prior: RANSAC over minimal sets of stereo points (3D-3D alignment) and of stereo lines, scored by
/// the reprojection of both kinds in both images. Used where the motion model fails (lost frames, wide gaps, loops).
/// Seeded, so equal input gives equal output. nullopt where no pose has `min_inliers` (points + 2 x lines).
std::optional<SE3> EstimatePoseRansac(const std::vector<PointObservation>& points,
                                      const std::vector<LineObservation>& lines, const StereoCamera& camera,
                                      int min_inliers, double inlier_px, uint64_t seed);

}  // namespace plslam
