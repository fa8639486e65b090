#include "vo_process/motion_model.h"

#include <algorithm>

namespace plslam {
namespace {

// Intervals up to which constant velocity is extrapolated, in multiples of the one it was measured over.
constexpr double kMaxExtrapolation = 2.0;
// Uncertainty of a rotation from which on a prediction says nothing.
constexpr double kAnyRotation_rad = 1.0;

}  // namespace

MotionPrediction MotionModel::Predict(double dt_s) const {
  const double horizon_s = std::min(dt_s, kMaxExtrapolation * last_dt_s_);
  const double sigma_m = 0.5 * options_.max_acceleration_m_s2 * dt_s * dt_s;
  const double sigma_rad = 0.5 * options_.max_angular_acceleration_rad_s2 * dt_s * dt_s;
  MotionPrediction prediction;
  prediction.T_prev_c = SE3::Exp(velocity_ * horizon_s);
  prediction.covariance = Matrix6d::Zero();
  prediction.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
  prediction.covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  prediction.goes_on = !slowed_ && dt_s <= kMaxExtrapolation * last_dt_s_ && sigma_rad < kAnyRotation_rad;
  return prediction;
}

void MotionModel::Observe(const SE3& T_prev_c, double dt_s) {
  velocity_ = T_prev_c.Log() / dt_s;
  last_dt_s_ = dt_s;
  slowed_ = false;
}

void MotionModel::Slow() {
  velocity_ *= 0.5;
  slowed_ = true;
}

}  // namespace plslam
