#pragma once

#include <span>

#include <Eigen/Core>

namespace plslam {

/// One number measured of a 3D position: `residual` = measured - expected, `J` its derivative by the position.
struct LinearMeasurement {
  Eigen::RowVector3d J = Eigen::RowVector3d::Zero();
  double residual = 0.0;
  double variance = 1.0;
};

/// Kalman update of a position by independent measurements linearised at it. Leaves both as they are where the result is
/// not finite, and returns false.
bool FuseMeasurements(std::span<const LinearMeasurement> measurements, Eigen::Vector3d& position,
                      Eigen::Matrix3d& covariance);

}  // namespace plslam
