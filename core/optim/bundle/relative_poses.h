#pragma once

#include <vector>

#include "core/optim/bundle/pose_system.h"
#include "core/optim/bundle/relative_pose_cost.h"

namespace plslam {

/// The relative poses of an adjustment that count: measured well, between poses that see something, of which one is free.
class RelativePoses {
 public:
  /// Where their loss turns linear, in standard deviations.
  static constexpr double kDelta = 3.0;

  RelativePoses(const std::vector<RelativePose>& measured, std::vector<AdjustedPose>& poses);

  /// Adds information and gradient at the poses as they are. Returns the loss.
  double Linearise(PoseSystem& system) const;

  /// Twice the cost at the poses as they are.
  double Loss() const;

  /// Says of their poses that they are held.
  void HoldPoses();

  const std::vector<RelativePoseCost>& costs() const { return costs_; }

 private:
  std::vector<RelativePoseCost> costs_;
};

}  // namespace plslam
