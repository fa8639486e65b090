// SPDX-License-Identifier: BSD-3-Clause
#include "core/motion/point_batch.h"

#include <algorithm>
#include <limits>

#include "core/motion/normal_equations.h"

namespace plslam {
namespace {

using Lanes = PointBatch::Lanes;
using Block = PointBatch::Block;
constexpr int kLanes = PointBatch::kLanes;
constexpr double kLargest = std::numeric_limits<double>::max();
/// Pixels^2: variances up to this, or NaN, are invalid.
constexpr double kMinPivot = 1e-30;

/// Points in the camera frame and their residuals. J is [k 0 -kX; 0 k -kY; 0 0 k2].
struct Seen {
  Lanes x, y, z;
  Lanes X, Y, k, k2;
  Lanes r0, r1, r2;
  /// Not clamped.
  Lanes depth;
};

Seen Project(const Block& b, const PoseView& view) {
  const Eigen::Matrix3d& R = view.R;
  const StereoCamera& camera = view.camera;
  Seen s;
  s.x = R(0, 0) * b.x + R(0, 1) * b.y + R(0, 2) * b.z + view.t.x();
  s.y = R(1, 0) * b.x + R(1, 1) * b.y + R(1, 2) * b.z + view.t.y();
  s.depth = R(2, 0) * b.x + R(2, 1) * b.y + R(2, 2) * b.z + view.t.z();
  s.z = s.depth.max(view.min_depth_m);
  const Lanes inverse_z = s.z.inverse();
  s.X = s.x * inverse_z;
  s.Y = s.y * inverse_z;
  s.k = camera.f_px * inverse_z;
  // Without a disparity the third residual is 0 at all positions.
  s.k2 = -camera.baseline_m * s.k * inverse_z * b.has_disparity;
  s.r0 = b.u - (camera.f_px * s.X + camera.cx_px);
  s.r1 = b.v - (camera.f_px * s.Y + camera.cy_px);
  s.r2 = (b.disparity - camera.baseline_m * s.k) * b.has_disparity;
  return s;
}

struct Vector {
  Lanes x, y, z;
  Lanes Dot(const Vector& o) const { return x * o.x + y * o.y + z * o.z; }
};

Vector LandmarkCovarianceTimes(const Block& b, const Vector& v) {
  return {b.cxx * v.x + b.cxy * v.y + b.cxz * v.z, b.cxy * v.x + b.cyy * v.y + b.cyz * v.z,
          b.cxz * v.x + b.cyz * v.y + b.czz * v.z};
}

/// Lower triangle of S.
struct Covariance {
  Lanes s00, s10, s11, s20, s21, s22;
};

Covariance ResidualCovariance(const Block& b, const Seen& s, const Eigen::Matrix3d& R, double sigma_floor_px) {
  // Rows of J R without their factors k, k and k2.
  const Vector row0{R(0, 0) - s.X * R(2, 0), R(0, 1) - s.X * R(2, 1), R(0, 2) - s.X * R(2, 2)};
  const Vector row1{R(1, 0) - s.Y * R(2, 0), R(1, 1) - s.Y * R(2, 1), R(1, 2) - s.Y * R(2, 2)};
  const Vector row2{Lanes::Constant(R(2, 0)), Lanes::Constant(R(2, 1)), Lanes::Constant(R(2, 2))};
  const Vector c0 = LandmarkCovarianceTimes(b, row0);
  const Vector c1 = LandmarkCovarianceTimes(b, row1);
  const Vector c2 = LandmarkCovarianceTimes(b, row2);
  const Lanes sigma = b.sigma_px.max(sigma_floor_px);
  const Lanes sigma_d = b.sigma_disparity_px.max(sigma_floor_px);
  const Lanes k_k = s.k * s.k;
  const Lanes k_k2 = s.k * s.k2;
  return {k_k * row0.Dot(c0) + sigma * sigma,
          k_k * row1.Dot(c0),
          k_k * row1.Dot(c1) + sigma * sigma,
          k_k2 * row2.Dot(c0),
          k_k2 * row2.Dot(c1),
          s.k2 * s.k2 * row2.Dot(c2) + sigma_d * sigma_d};
}

/// Position in the camera, whitened residual, and G, whose element (0, 1) is 0. All zero if `usable` is 0, else 1.
struct Whitened {
  Lanes x, y, z;
  Lanes r0, r1, r2;
  Lanes g00, g02, g10, g11, g12, g20, g21, g22;
  Lanes squared;
  Lanes usable;

  void Clear(int lane) {
    for (Lanes* value :
         {&x, &y, &z, &r0, &r1, &r2, &g00, &g02, &g10, &g11, &g12, &g20, &g21, &g22, &squared, &usable}) {
      (*value)[lane] = 0.0;
    }
  }
};

Whitened Whiten(const Block& b, const PoseView& view, double sigma_floor_px) {
  const Seen s = Project(b, view);
  const Covariance c = ResidualCovariance(b, s, view.R, sigma_floor_px);
  // Cholesky factor l of S, with the inverses i of its diagonal.
  const Lanes i0 = c.s00.max(kMinPivot).sqrt().inverse();
  const Lanes l10 = c.s10 * i0;
  const Lanes l20 = c.s20 * i0;
  const Lanes pivot1 = c.s11 - l10 * l10;
  const Lanes i1 = pivot1.max(kMinPivot).sqrt().inverse();
  const Lanes l21 = (c.s21 - l20 * l10) * i1;
  const Lanes pivot2 = c.s22 - l20 * l20 - l21 * l21;
  const Lanes i2 = pivot2.max(kMinPivot).sqrt().inverse();

  Whitened w;
  w.x = s.x;
  w.y = s.y;
  w.z = s.z;
  w.r0 = s.r0 * i0;
  w.r1 = (s.r1 - l10 * w.r0) * i1;
  w.r2 = (s.r2 - l20 * w.r0 - l21 * w.r1) * i2;
  w.squared = w.r0 * w.r0 + w.r1 * w.r1 + w.r2 * w.r2;
  w.g00 = i0 * s.k;
  w.g02 = -w.g00 * s.X;
  w.g10 = -i1 * l10 * w.g00;
  w.g11 = i1 * s.k;
  w.g12 = i1 * (-s.k * s.Y - l10 * w.g02);
  w.g20 = i2 * (-l20 * w.g00 - l21 * w.g10);
  w.g21 = -i2 * l21 * w.g11;
  w.g22 = i2 * (s.k2 - l20 * w.g02 - l21 * w.g12);
  w.usable.setOnes();
  const Lanes smallest_pivot = c.s00.min(pivot1).min(pivot2);
  for (int lane = 0; lane < kLanes; ++lane) {
    const bool usable =
        s.depth[lane] > view.min_depth_m && smallest_pivot[lane] > kMinPivot && w.squared[lane] <= kLargest;
    if (!usable) w.Clear(lane);
  }
  return w;
}

/// Sums of the lower triangle of the Hessian, by 3x3 blocks, and of the gradient.
struct Sums {
  std::array<Lanes, 6> translation;
  std::array<Lanes, 9> rotation_translation;
  std::array<Lanes, 6> rotation;
  std::array<Lanes, 6> gradient;

  Sums() {
    for (auto* list : {&translation, &rotation, &gradient}) list->fill(Lanes::Zero());
    rotation_translation.fill(Lanes::Zero());
  }

  void Add(const Whitened& w, const Lanes& weight) {
    const Lanes h00 = weight * w.g00, h02 = weight * w.g02, h10 = weight * w.g10, h11 = weight * w.g11;
    const Lanes h12 = weight * w.g12, h20 = weight * w.g20, h21 = weight * w.g21, h22 = weight * w.g22;
    const Lanes xx = h00 * w.g00 + h10 * w.g10 + h20 * w.g20;
    const Lanes xy = h10 * w.g11 + h20 * w.g21;
    const Lanes xz = h00 * w.g02 + h10 * w.g12 + h20 * w.g22;
    const Lanes yy = h11 * w.g11 + h21 * w.g21;
    const Lanes yz = h11 * w.g12 + h21 * w.g22;
    const Lanes zz = h02 * w.g02 + h12 * w.g12 + h22 * w.g22;
    AddHessian(w, {xx, xy, yy, xz, yz, zz},
               {w.y * xz - w.z * xy, w.y * yz - w.z * yy, w.y * zz - w.z * yz,  //
                w.z * xx - w.x * xz, w.z * xy - w.x * yz, w.z * xz - w.x * zz,  //
                w.x * xy - w.y * xx, w.x * yy - w.y * xy, w.x * yz - w.y * xz});
    const Lanes bx = h00 * w.r0 + h10 * w.r1 + h20 * w.r2;
    const Lanes by = h11 * w.r1 + h21 * w.r2;
    const Lanes bz = h02 * w.r0 + h12 * w.r1 + h22 * w.r2;
    gradient[0] += bx;
    gradient[1] += by;
    gradient[2] += bz;
    gradient[3] += w.y * bz - w.z * by;
    gradient[4] += w.z * bx - w.x * bz;
    gradient[5] += w.x * by - w.y * bx;
  }

  /// Lower triangle of A, and B = [p]x A by rows.
  void AddHessian(const Whitened& w, const std::array<Lanes, 6>& A, const std::array<Lanes, 9>& B) {
    for (size_t i = 0; i < 6; ++i) translation[i] += A[i];
    for (size_t i = 0; i < 9; ++i) rotation_translation[i] += B[i];
    rotation[0] += w.y * B[2] - w.z * B[1];
    rotation[1] += w.y * B[5] - w.z * B[4];
    rotation[2] += w.z * B[3] - w.x * B[5];
    rotation[3] += w.y * B[8] - w.z * B[7];
    rotation[4] += w.z * B[6] - w.x * B[8];
    rotation[5] += w.x * B[7] - w.y * B[6];
  }

  void AddTo(NormalEquations& sum) const {
    for (int i = 0, k = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j, ++k) {
        sum.H_data(i, j) += translation[k].sum();
        sum.H_data(3 + i, 3 + j) += rotation[k].sum();
      }
      for (int j = 0; j < 3; ++j) sum.H_data(3 + i, j) += rotation_translation[3 * i + j].sum();
    }
    for (int i = 0; i < 6; ++i) sum.g(i) += gradient[i].sum();
  }
};

}  // namespace

PointBatch::PointBatch(const std::vector<PreparedPoint>& points) : size_(points.size()) {
  blocks_.reserve((size_ + kLanes - 1) / kLanes);
  for (size_t first = 0; first < size_; first += kLanes) {
    Block b;
    for (int lane = 0; lane < kLanes; ++lane) {
      // Repetitions of the last point fill the last block; their results are not read.
      const PreparedPoint& p = points[std::min(first + lane, size_ - 1)];
      b.x[lane] = p.p_ref.x();
      b.y[lane] = p.p_ref.y();
      b.z[lane] = p.p_ref.z();
      b.cxx[lane] = p.covariance(0, 0);
      b.cxy[lane] = p.covariance(1, 0);
      b.cxz[lane] = p.covariance(2, 0);
      b.cyy[lane] = p.covariance(1, 1);
      b.cyz[lane] = p.covariance(2, 1);
      b.czz[lane] = p.covariance(2, 2);
      b.u[lane] = p.uvd.x();
      b.v[lane] = p.uvd.y();
      b.disparity[lane] = p.uvd.z();
      b.sigma_px[lane] = p.sigma_px;
      b.sigma_disparity_px[lane] = p.has_disparity ? p.sigma_disparity_px : 1.0;
      b.has_disparity[lane] = p.has_disparity ? 1.0 : 0.0;
    }
    blocks_.push_back(b);
  }
}

void PointBatch::AddTo(const std::vector<char>& active, const PoseView& view, double delta, double hidden_cost,
                       NormalEquations& sum, std::array<int, 5>& count_by_dimension) const {
  const double inverse_d2 = 1.0 / (delta * delta);
  Sums sums;
  Lanes cost = Lanes::Zero(), squares = Lanes::Zero(), weighted_squares = Lanes::Zero();
  Lanes used = Lanes::Zero(), with_disparity = Lanes::Zero();
  for (size_t i = 0; i < blocks_.size(); ++i) {
    Lanes wanted = Lanes::Zero();
    for (int lane = 0; lane < kLanes && kLanes * i + lane < size_; ++lane) wanted[lane] = active[kLanes * i + lane];
    if (wanted.sum() == 0.0) continue;
    const Whitened w = Whiten(blocks_[i], view, 0.0);
    const Lanes usable = wanted * w.usable;
    const Lanes squared = usable * w.squared;
    // Pseudo-Huber: loss and weight share their root.
    const Lanes root = (1.0 + squared * inverse_d2).sqrt();
    const Lanes weight = usable / root;
    sums.Add(w, weight);
    cost += 2.0 * squared / (root + 1.0) + (wanted - usable) * hidden_cost;
    squares += squared;
    weighted_squares += weight * squared;
    used += usable;
    with_disparity += usable * blocks_[i].has_disparity;
  }
  sums.AddTo(sum);
  sum.cost += cost.sum();
  sum.squares += squares.sum();
  sum.weighted_squares += weighted_squares.sum();
  count_by_dimension[3] += static_cast<int>(with_disparity.sum());
  count_by_dimension[2] += static_cast<int>(used.sum() - with_disparity.sum());
}

std::vector<double> PointBatch::SquaredNorms(const PoseView& view, double sigma_floor_px) const {
  std::vector<double> norms(size_);
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const Whitened w = Whiten(blocks_[i], view, sigma_floor_px);
    for (int lane = 0; lane < kLanes && kLanes * i + lane < size_; ++lane) {
      norms[kLanes * i + lane] = w.usable[lane] > 0.0 ? w.squared[lane] : std::numeric_limits<double>::infinity();
    }
  }
  return norms;
}

}  // namespace plslam
