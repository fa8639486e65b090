// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/motion/motion_estimator.h"

namespace plslam {

/// Minimal sets of neighbouring points, for a pose that only a part of the image agrees with: at most `max_hypotheses`
/// sets, each of points within `radius_px` of the first whose disparities differ by at most `relative_disparity`.
struct Neighbourhood {
  double radius_px = 80.0;
  double relative_disparity = 0.3;
  int max_hypotheses = 100;
};

/// Estimates a pose without a prior: RANSAC over minimal sets of stereo points (3D-3D alignment) and of stereo lines,
/// scored by the reprojection of both feature types in both images. Used if the motion model fails (lost frames, wide
/// gaps, loops). Seeded, so equal input gives equal output. Returns nullopt if no pose has `min_inliers` (points + 2 x
/// lines).
std::optional<SE3> EstimatePoseRansac(const std::vector<PointCorrespondence>& points,
                                      const std::vector<LineCorrespondence>& lines, const StereoCamera& camera,
                                      int min_inliers, double inlier_px, uint64_t seed,
                                      const std::optional<Neighbourhood>& neighbourhood = std::nullopt);

}  // namespace plslam
