// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/accuracy/association.h"
#include "core/io/trajectories/pose_covariance.h"

namespace plslam {

/// Summary of non-negative errors. All zero if there are none (`n` = 0).
struct Statistics {
  int n = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< mean of the two middle values if `n` is even
  double max = 0.0;
};

Statistics Summarise(std::vector<double> values);

/// Returns the quantile of the chi-square distribution by the approximation of Wilson and Hilferty (1931), for the
/// two-sided 95 % interval: `z` is +-1.959964. The error is below 3 % at 6 degrees of freedom, and 0.1 % from 60 on.
double ChiSquareQuantile(double degrees_of_freedom, double z);

/// Consistency of covariances with errors: NEES x^T C^-1 x of the error x with T_true = T * Exp(x) (Bar-Shalom et al.
/// 2001, §5.4). Its mean is 6 for consistent covariances.
struct Consistency {
  int n = 0;
  int singular = 0;  ///< samples omitted, because their covariance is not positive definite
  double mean_nees = 0.0;
  /// Share of the samples above the 95 % quantile of one sample (12.59).
  double above_95_percent = 0.0;
  /// 95 % bounds on the mean of n independent samples.
  double lower_bound = 0.0;
  double upper_bound = 0.0;
};

/// Returns the consistency of poses relative to the first pair that has a covariance: both trajectories are aligned
/// there, and its covariance, propagated, is subtracted from later ones. Errors of successive poses are correlated, so
/// the mean varies more than the bounds indicate.
Consistency PoseConsistency(const PosePairs& pairs, const std::vector<PoseCovariance>& covariances);

/// Returns the consistency of motions over `span` frames, from each estimated pose with so many successors; the
/// covariances of the steps are composed as if independent, as a filter does. `covariances` are those of the motions
/// that end at their time; spans with a pose without covariance are skipped. Spans that share no frame are nearly
/// independent, and the bounds count these.
Consistency MotionConsistency(const PosePairs& pairs, const std::vector<PoseCovariance>& covariances,
                              size_t span = 1);

}  // namespace plslam
