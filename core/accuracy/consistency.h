// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "core/accuracy/association.h"
#include "core/io/trajectories/pose_covariance.h"

namespace plslam {

/// Summary of non-negative errors. All zero where there are none (`n` tells).
struct Statistics {
  int n = 0;
  double rmse = 0.0;
  double mean = 0.0;
  double median = 0.0;  ///< mean of the two middle values where `n` is even
  double max = 0.0;
};

Statistics Summarise(std::vector<double> values);

/// Quantile of the chi-square distribution by the approximation of Wilson and Hilferty (1931), for the two-sided 95 %
/// interval: `z` is +-1.959964. Off by less than 3 % at 6 degrees of freedom and 0.1 % from 60 on.
double ChiSquareQuantile(double degrees_of_freedom, double z);

/// Whether covariances fit the errors: NEES x^T C^-1 x of the error x with T_true = T * Exp(x) (Bar-Shalom et al.
/// 2001, §5.4). With honest covariances it has mean 6.
struct Consistency {
  int n = 0;
  int singular = 0;  ///< left out: no positive definite covariance
  double mean_nees = 0.0;
  /// Share of the samples above the 95 % quantile of one sample (12.59).
  double above_95_percent = 0.0;
  /// The mean of n independent samples lies between these with 95 %.
  double lower_bound = 0.0;
  double upper_bound = 0.0;
};

/// Of the pose since the first pair that has a covariance: both trajectories are made equal there, and its
/// covariance, carried along, is taken off the later ones. Errors of successive poses are correlated, so the mean
/// scatters more than the bounds say.
Consistency PoseConsistency(const PosePairs& pairs, const std::vector<PoseCovariance>& covariances);

/// Of the motion over `span` frames, from each estimated pose that is followed by so many; the covariances of its
/// steps are composed as a filter does, which takes them as independent. `covariances` belong to the motion that ends
/// at their time; a span with a pose without a row is passed over. Spans that share no frame are as good as
/// independent, and the bounds count those.
Consistency MotionConsistency(const PosePairs& pairs, const std::vector<PoseCovariance>& covariances,
                              size_t span = 1);

}  // namespace plslam
