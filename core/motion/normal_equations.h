// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/motion/line_residual.h"
#include "core/motion/point_batch.h"
#include "core/motion/point_residual.h"
#include "core/motion/robust.h"

namespace plslam {

/// Valid correspondences of one stereo frame, with their indices in the caller's lists.
struct PreparedCorrespondences {
  std::vector<PreparedPoint> points;
  std::vector<PreparedLine> lines;
  std::vector<int> point_index;
  std::vector<int> line_index;
  /// The same points in structure-of-arrays layout.
  PointBatch point_batch;

  PreparedCorrespondences(const std::vector<PointCorrespondence>& point_correspondences,
                          const std::vector<LineCorrespondence>& line_correspondences, const MotionOptions& options);
};

/// Flags of the prepared correspondences that take part.
struct ActiveSet {
  std::vector<char> points;
  std::vector<char> lines;

  bool operator==(const ActiveSet&) const = default;
  int CountPoints() const;
  int CountLines() const;
  int Count() const { return CountPoints() + CountLines(); }
};

/// Weighted normal equations H x = -g of the motion at one pose, and sums for their evaluation.
struct NormalEquations {
  Matrix6d H_data = Matrix6d::Zero();
  Matrix6d H_prior = Matrix6d::Zero();
  Vector6d g = Vector6d::Zero();
  double cost = 0.0;
  int dimensions = 0;
  double squares = 0.0;
  double weighted_squares = 0.0;
  double expected_weighted_squares = 0.0;
  /// Sums over the residuals of the expectations of `RobustExpectation`, times their dimension.
  double expected_weight = 0.0;
  double expected_A = 0.0;
  double expected_B = 0.0;

  Matrix6d H() const { return H_data + H_prior; }
};

/// Sums over all active correspondences at `T_cur_ref`.
NormalEquations BuildNormalEquations(const PreparedCorrespondences& correspondences, const ActiveSet& active,
                                     const SE3& T_cur_ref, const StereoCamera& camera,
                                     const RobustExpectations& expectations, const MotionOptions& options);

/// Squared whitened norms, their expected medians, for the robust scale, and their gates: a correspondence is an inlier
/// if `squared <= scale^2 * gate`. Infinite if it is not visible. Sigmas are at least `min_scale_px` here.
struct Deviation {
  double squared;
  double median;
  double gate;
};
std::vector<Deviation> PointDeviations(const PreparedCorrespondences& correspondences, const SE3& T_cur_ref,
                                       const StereoCamera& camera, const MotionOptions& options);
std::vector<Deviation> LineDeviations(const PreparedCorrespondences& correspondences, const SE3& T_cur_ref,
                                      const StereoCamera& camera, const MotionOptions& options);

}  // namespace plslam
