// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/motion/point_residual.h"
#include "core/motion/residual.h"

namespace plslam {

struct NormalEquations;

/// The points of a frame, several at once, for the normal equations: most of a motion estimate's time is the same two
/// hundred operations on each of them.
///
/// The residual of a point is measured minus predicted (u, v, disparity), in pixels; its covariance is S = J R C R^T
/// J^T + noise, with J the derivative of the projection and C the covariance of the landmark. Whitened by the
/// Cholesky factor of S, J becomes G, and A = w G^T G is the information of the measurement about the point's position
/// p in the camera. Under a perturbation (t, r) the point moves by -t - r x p, so that the 6x6 Hessian is
///   [ A         A [p]x^T      ]
///   [ [p]x A    [p]x A [p]x^T ],
/// which costs less than whitening and squaring rows of six.
class PointBatch {
 public:
  /// Lanes of a block: two registers of the baseline processor, so that one's division does not wait for the other's.
  static constexpr int kLanes = 4;
  using Lanes = Eigen::Array<double, kLanes, 1>;

  PointBatch() = default;
  explicit PointBatch(const std::vector<PreparedPoint>& points);

  /// Adds the normal equations of the `active` points (one flag each) at `view`, with pseudo-Huber weights; only the
  /// lower triangle of the symmetric Hessian. A point behind the camera, too near, or without a valid covariance adds
  /// only `hidden_cost`; the others are counted by the dimension of their residual.
  void AddTo(const std::vector<char>& active, const PoseView& view, double delta, double hidden_cost,
             NormalEquations& sum, std::array<int, 5>& count_by_dimension) const;

  /// Returns squared whitened residuals, with sigmas of at least `sigma_floor_px`; infinity for invisible points.
  std::vector<double> SquaredNorms(const PoseView& view, double sigma_floor_px) const;

  struct Block {
    Lanes x, y, z;
    Lanes cxx, cxy, cxz, cyy, cyz, czz;
    Lanes u, v, disparity;
    Lanes sigma_px, sigma_disparity_px;
    /// 1 if there is a disparity, else 0.
    Lanes has_disparity;
  };

 private:
  size_t size_ = 0;
  std::vector<Block> blocks_;
};

}  // namespace plslam
