#pragma once

#include "core/geometry/se3.h"
#include "vo_process/options.h"

namespace plslam {

/// What is expected before looking: motion since the last frame, T_prev_c, with the covariance of its right
/// perturbation.
struct MotionPrediction {
  SE3 T_prev_c;
  Matrix6d covariance = Matrix6d::Identity();
  /// The frame before was measured, and so lately that its motion says where to look: the motion goes on.
  bool goes_on = false;
};

/// Constant velocity, with bounded acceleration as its uncertainty.
class MotionModel {
 public:
  explicit MotionModel(const TrackingOptions& options) : options_(options) {}

  /// `dt_s` > 0. Across a gap much longer than the last interval the velocity is not trusted to go on.
  MotionPrediction Predict(double dt_s) const;

  /// Learns from a measured motion.
  void Observe(const SE3& T_prev_c, double dt_s);

  /// A motion has been measured, so that predictions say more than "anywhere near".
  bool knows_motion() const { return last_dt_s_ > 0.0; }

  /// After a frame that was not measured: half the velocity, so that a lost camera does not fly away.
  void Slow();

  /// All that it goes on with, for `core/io/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.velocity_, self.last_dt_s_, self.slowed_);
  }

 private:
  TrackingOptions options_;
  Vector6d velocity_ = Vector6d::Zero();
  double last_dt_s_ = 0.0;
  bool slowed_ = false;
};

}  // namespace plslam
