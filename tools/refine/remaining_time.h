// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace plslam::refine {

/// Time until the end of a number of solves that follow each other, by the time of the iterations so far. The cost of a
/// solve is expected to fall by the same factor in each iteration until it falls by less than Ceres' tolerance of 1e-6;
/// later solves are expected to have as many iterations as those that have ended.
class RemainingTime {
 public:
  /// `solves` is the number that is expected in all; more may follow.
  explicit RemainingTime(int solves) : solves_(solves) {}

  /// Takes the cost after an iteration (0: a new solve begins with this cost) at a time since the start. Returns the
  /// expected time from there to the end [s].
  double After(int iteration, double cost, double elapsed_s);

 private:
  double IterationsOfOthers() const;

  int solves_;
  int begun_ = 0;
  int ended_iterations_ = 0;
  int iteration_ = 0;
  double cost_ = 0.0;
  /// Iterations that the present solve still needs.
  double left_ = 0.0;
  /// Share of the cost that the iteration before gained.
  double gain_ = 0.0;
};

}  // namespace plslam::refine
