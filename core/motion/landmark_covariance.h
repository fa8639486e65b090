#pragma once

#include <Eigen/Core>

namespace plslam {

/// False for a covariance that is not finite or has a negative variance, and for a position so uncertain (a hundred
/// times its distance) that linearising at it means nothing.
inline bool IsUsableCovariance(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& position) {
  constexpr double kUncertain = 1e4;
  return covariance.allFinite() && covariance.diagonal().minCoeff() >= 0.0 &&
         covariance.trace() <= kUncertain * position.squaredNorm();
}

}  // namespace plslam
