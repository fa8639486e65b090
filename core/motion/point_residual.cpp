// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/point_residual.h"

#include "core/motion/residual.h"

namespace plslam {

std::optional<PreparedPoint> Prepare(const PointCorrespondence& o, const MotionOptions& options) {
  const bool finite = o.p_ref.allFinite() && o.uvd.allFinite() && std::isfinite(o.sigma_px);
  if (!finite || !(o.sigma_px > 0.0)) return std::nullopt;
  PreparedPoint point{o.p_ref, Eigen::Matrix3d::Zero(), o.uvd, o.sigma_px, o.sigma_disparity_px, o.uvd.z() >= 0.0};
  if (point.has_disparity && !(o.sigma_disparity_px > 0.0 && std::isfinite(o.sigma_disparity_px)))
    return std::nullopt;
  if (!IsUsableCovariance(o.covariance, o.p_ref)) return std::nullopt;
  if (options.landmark_covariance) point.covariance = o.covariance;
  return point;
}

}  // namespace plslam
