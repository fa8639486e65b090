#pragma once

#include <optional>

#include "core/geometry/se3.h"

namespace plslam {

/// Differential entropy h = 3 (1 + log 2 pi) + 0.5 log |cov| of a motion (PL-SLAM §IV.D), in nats. From eigenvalues, so
/// determinants far below the smallest double are fine. nullopt for a covariance that is not finite or not positive definite.
std::optional<double> MotionEntropy(const Matrix6d& covariance);

/// The paper's ratio alpha = h(now) / h(first) that falls below a threshold (0.9) when a new keyframe is due.
///
/// It is meant for entropies below zero, as covariances of millimetres and milliradians have: more uncertainty
/// moves h(now) towards zero and alpha below 1. Where h(first) is not clearly negative the quotient loses this meaning (it
/// jumps, or grows with uncertainty), so there alpha = 1 - (h(now) - h(first)) / kReference instead, which has the
/// same sign and a comparable slope; kReference is the entropy's usual size, 30 nats. Always: 1 at equal
/// uncertainty, smaller for more, larger for less. nullopt where either entropy is.
std::optional<double> EntropyRatio(const Matrix6d& covariance_first, const Matrix6d& covariance_now);

}  // namespace plslam
