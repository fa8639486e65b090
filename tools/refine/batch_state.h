// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <vector>

#include "core/optim/bundle/line_cost.h"
#include "core/optim/reference/line_functor.h"
#include "core/optim/reference/point_functor.h"
#include "core/optim/reference/pose_parameters.h"
#include "tools/refine/batch_problem.h"

namespace plslam::refine {

/// Values of all parameter blocks, and the functions that make the residuals of them.
class State {
 public:
  explicit State(const BatchProblem& problem)
      : problem_(problem), bundle_(problem.bundle), pair_(problem.pair), poses_(bundle_.poses.size()) {
    for (const BundlePoint& point : bundle_.points) points_.push_back(point.p_w);
    for (const BundleLine& line : bundle_.lines) {
      const bool usable = AdjustedLine(line).IsUsable();
      starts_.push_back(
          {line.segment_w, usable ? DirectionsAcross(line.segment_w) : Eigen::Matrix<double, 3, 2>::Zero()});
      lines_.emplace_back(Eigen::Vector4d::Zero());
    }
    for (Vector6d& pose : poses_) pose.setZero();
  }

  double* Pose(int i) { return poses_[static_cast<size_t>(i)].data(); }
  double* Point(int i) { return points_[static_cast<size_t>(i)].data(); }
  double* Line(int i) { return lines_[static_cast<size_t>(i)].data(); }
  double* Pair() { return pair_.data(); }

  SE3 T_w_c(int i) const {
    return reference::MovedPose(bundle_.poses[static_cast<size_t>(i)].T_w_c, poses_[static_cast<size_t>(i)].data());
  }
  Segment3 SegmentOf(int i) const {
    const auto ends = starts_[static_cast<size_t>(i)].Ends(lines_[static_cast<size_t>(i)].data());
    return {ends[0], ends[1]};
  }

  reference::PointFunctor PointOf(size_t i) const {
    const PointObservation& seen = bundle_.point_observations[i];
    return {seen, bundle_.poses[static_cast<size_t>(seen.pose)].T_w_c, bundle_.camera};
  }
  reference::PairPointFunctor PairPointOf(size_t i) const {
    reference::PairPointFunctor functor{PointOf(i)};
    functor.twist = TwistOf(functor.ideal.observation.pose);
    if (!problem_.row_offsets.empty()) {
      functor.row_offset_px = problem_.row_offsets[i].offset_px;
      functor.sigma_row_px = problem_.row_offsets[i].sigma_px;
    }
    return functor;
  }
  /// Anchored at the present state.
  reference::LineFunctor LineOf(size_t i) const {
    const LineObservation& seen = bundle_.line_observations[i];
    reference::LineFunctor functor(seen, starts_[static_cast<size_t>(seen.line)],
                                   bundle_.poses[static_cast<size_t>(seen.pose)].T_w_c, bundle_.camera);
    functor.Anchor(T_w_c(seen.pose), SegmentOf(seen.line));
    functor.twist = TwistOf(seen.pose);
    return functor;
  }

  BatchFit Fit() {
    BatchFit fit;
    double r[4] = {0.0, 0.0, 0.0, 0.0};
    for (size_t i = 0; i < bundle_.point_observations.size(); ++i) {
      const PointObservation& seen = bundle_.point_observations[i];
      const reference::PairPointFunctor functor = PairPointOf(i);
      const bool front = functor(Pose(seen.pose), Point(seen.point), Pair(), r);
      // The rows of the plain observation: gates compare states with and without the measured rows.
      fit.points.push_back(front ? Squared(r, functor.ideal.rows()) : std::numeric_limits<double>::infinity());
      fit.points_px2.push_back(front ? seen.sigma_px * seen.sigma_px * Squared(r, 2)
                                     : std::numeric_limits<double>::infinity());
    }
    for (size_t i = 0; i < bundle_.line_observations.size(); ++i) {
      const LineObservation& seen = bundle_.line_observations[i];
      const reference::LineFunctor functor = LineOf(i);
      const bool front = functor(Pose(seen.pose), Line(seen.line), Pair(), r);
      fit.lines.push_back(front ? Squared(r, functor.rows()) : std::numeric_limits<double>::infinity());
      const double q = r[functor.rows() / 2];
      fit.lines_px2.push_back(front ? 0.5 * seen.sigma_px * seen.sigma_px * (r[0] * r[0] + q * q)
                                    : std::numeric_limits<double>::infinity());
      fit.line_rows.push_back(functor.rows());
    }
    return fit;
  }

  void Fill(BatchResult& result) const {
    for (size_t i = 0; i < poses_.size(); ++i) result.T_w_c.push_back(T_w_c(static_cast<int>(i)));
    result.points = points_;
    for (size_t i = 0; i < lines_.size(); ++i) result.lines.push_back(SegmentOf(static_cast<int>(i)));
    result.pair = pair_;
  }

 private:
  static double Squared(const double* r, int rows) {
    return Eigen::Map<const Eigen::VectorXd>(r, rows).squaredNorm();
  }
  Vector6d TwistOf(int pose) const {
    return problem_.twists.empty() ? Vector6d::Zero().eval() : problem_.twists[static_cast<size_t>(pose)];
  }

  const BatchProblem& problem_;
  const BundleProblem& bundle_;
  PairParameters pair_;
  std::vector<Vector6d> poses_;
  std::vector<Eigen::Vector3d> points_;
  std::vector<Eigen::Vector4d> lines_;
  std::vector<reference::LineStart> starts_;
};

}  // namespace plslam::refine
