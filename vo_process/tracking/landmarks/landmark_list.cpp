// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/landmark_list.h"

namespace plslam::vo {

bool FuseMeasurements(std::span<const LinearMeasurement> measurements, Eigen::Vector3d& position,
                      Eigen::Matrix3d& covariance) {
  Eigen::Vector3d step = Eigen::Vector3d::Zero();
  Eigen::Matrix3d P = covariance;
  // Independent measurements are applied one by one, which avoids inverting a matrix.
  for (const LinearMeasurement& m : measurements) {
    const Eigen::Vector3d PJ = P * m.J.transpose();
    const Eigen::Vector3d gain = PJ / (m.J * PJ + m.variance);
    step += gain * (m.residual - m.J * step);
    P -= gain * PJ.transpose();
  }
  if (!step.allFinite() || !P.allFinite()) return false;
  position += step;
  covariance = 0.5 * (P + P.transpose());
  return true;
}

}  // namespace plslam::vo
