// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include <Eigen/Core>
#include <Eigen/LU>

#include "core/optim/bundle/bundle.h"
#include "core/optim/reference/pose_parameters.h"
#include "core/optim/reference/stereo_pair.h"

namespace plslam::reference {

/// The infinite line through a segment of an image: its normal, and a point of it [px].
struct ImageLine {
  ImageLine() = default;
  ImageLine(const Eigen::Vector2d& p, const Eigen::Vector2d& q) : middle(0.5 * (p + q)) {
    const Eigen::Vector2d along = (q - p) / (q - p).norm();
    normal = {-along.y(), along.x()};
  }

  template <typename T>
  T Distance(const Eigen::Matrix<T, 2, 1>& px) const {
    return normal.x() * (px.x() - middle.x()) + normal.y() * (px.y() - middle.y());
  }

  Eigen::Vector2d normal = Eigen::Vector2d::UnitY();
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
};

/// The observed line in both images. `has_right` is false without disparities, or if the right segment is shorter than
/// a pixel.
struct StereoLineImages {
  explicit StereoLineImages(const LineObservation& seen) : left(seen.observed.p, seen.observed.q) {
    const Eigen::Vector2d p = seen.observed.p - Eigen::Vector2d(seen.disparity_p_px, 0.0);
    const Eigen::Vector2d q = seen.observed.q - Eigen::Vector2d(seen.disparity_q_px, 0.0);
    has_right = seen.disparity_p_px >= 0.0 && seen.disparity_q_px >= 0.0 && (q - p).norm() >= 1.0;
    if (has_right) right = ImageLine(p, q);
  }

  ImageLine left;
  ImageLine right;
  bool has_right;
};

/// A line of four parameters: its endpoints move in the two directions across the start segment.
struct LineStart {
  Segment3 segment_w;
  Eigen::Matrix<double, 3, 2> across;

  template <typename T>
  std::array<Vector3<T>, 2> Ends(const T* x) const {
    return {segment_w.p.cast<T>() + across.cast<T>() * Eigen::Matrix<T, 2, 1>(x[0], x[1]),
            segment_w.q.cast<T>() + across.cast<T>() * Eigen::Matrix<T, 2, 1>(x[2], x[3])};
  }
};

/// Line with four parameters (`LineCost`): each end of the observed segment has a place on the landmark, found when the
/// functor is made (`Anchor`), whose projections are compared with the infinite observed lines of both images. Rows for
/// each end: the left distance by the noise of the end; the right distance minus the part that the left one explains,
/// by the noise of the disparity. Parameters: pose and line; with a third block, a pair that need not be ideal.
struct LineFunctor {
  LineFunctor(const LineObservation& seen_in, const LineStart& line_in, const SE3& T_w_c,
              const StereoCamera& camera_in)
      : seen(seen_in), images(seen_in), line(line_in), start(T_w_c), camera(camera_in) {
    const double none[4] = {0.0, 0.0, 0.0, 0.0};
    const auto ends = line.Ends(none);
    Anchor(T_w_c, {ends[0], ends[1]});
  }

  /// The points of the segment that are nearest to the rays of the observed ends, at most half a length beyond it.
  void Anchor(const SE3& T_w_c, const Segment3& segment_w) {
    const Eigen::Vector3d p = T_w_c.Inverse() * segment_w.p;
    const Eigen::Vector3d along_c = T_w_c.Inverse() * segment_w.q - p;
    for (size_t i = 0; i < 2; ++i) {
      const Eigen::Vector2d& px = i == 0 ? seen.observed.p : seen.observed.q;
      const Eigen::Vector3d ray((px.x() - camera.cx_px) / camera.f_px, (px.y() - camera.cy_px) / camera.f_px, 1.0);
      // Normal equations of min |depth ray - (p + t along)|.
      Eigen::Matrix2d A;
      A << ray.dot(ray), -ray.dot(along_c), -ray.dot(along_c), along_c.dot(along_c);
      const Eigen::Vector2d depth_and_t = A.fullPivLu().solve(Eigen::Vector2d(ray.dot(p), -along_c.dot(p)));
      along[i] = std::clamp(depth_and_t.y(), -0.5, 1.5);
    }
  }

  int rows() const { return images.has_right ? 4 : 2; }

  template <typename T>
  bool operator()(const T* pose, const T* x, T* residuals) const {
    T ideal[kPairSize];
    std::fill(ideal, ideal + kPairSize, T(0.0));
    return (*this)(pose, x, ideal, residuals);
  }

  template <typename T>
  bool operator()(const T* pose, const T* x, const T* pair, T* residuals) const {
    const PoseAt<T> T_w_c(start, pose);
    const std::array<Vector3<T>, 2> ends_w = line.Ends(x);
    const double shared = images.left.normal.dot(images.right.normal);
    int row = 0;
    for (size_t i = 0; i < 2; ++i) {
      const Vector3<T> p_w = (1.0 - along[i]) * ends_w[0] + along[i] * ends_w[1];
      const Vector3<T> p_c = T_w_c.ToCamera(p_w);
      if (!(p_c.z() > camera.MinDepth())) return false;
      const PairPixels<T> pixels(camera, pair, twist, p_c);
      const T left = images.left.Distance(pixels.left);
      residuals[row++] = left / seen.sigma_px;
      if (!images.has_right) continue;
      if (!pixels.in_front) return false;
      const double of_disparity =
          images.right.normal.x() * (i == 0 ? seen.sigma_disparity_p_px : seen.sigma_disparity_q_px);
      const double of_its_own = 0.1 * seen.sigma_px;
      const double sigma = std::sqrt(of_disparity * of_disparity + of_its_own * of_its_own);
      residuals[row++] = (images.right.Distance(pixels.right) - shared * left) / sigma;
    }
    return true;
  }

  LineObservation seen;
  StereoLineImages images;
  LineStart line;
  SE3 start;
  StereoCamera camera;
  Vector6d twist = Vector6d::Zero();
  /// Place of each observed end on the landmark: 0 at its p, 1 at its q.
  std::array<double, 2> along{};
};

}  // namespace plslam::reference
