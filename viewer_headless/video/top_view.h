// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <vector>

namespace plslam::viewer {

/// The scene of a top view: positions in metres, in the levelled frame (LevelRotation): y is down and ignored.
struct TopViewScene {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> segments;
  std::vector<Eigen::Vector3d> path;  ///< of the camera, in order of time
};

/// The part of the ground that is drawn: it grows with path and landmarks and never shrinks, in steps, so that a film
/// of it is calm.
class TopViewWindow {
 public:
  void Include(const std::vector<Eigen::Vector3d>& path);
  /// The middle nine tenths of the landmarks along each axis, as far as they are no further from the path
  /// than it is large.
  void IncludeMiddle(const std::vector<Eigen::Vector3d>& points);
  Eigen::Vector2d centre_m() const { return 0.5 * (low_ + high_); }
  /// Side of the square that is to be seen.
  double side_m() const { return side_m_; }

 private:
  void Grow(const Eigen::Vector2d& low, const Eigen::Vector2d& high);

  bool empty_ = true;
  /// Bounds of the path alone, and of the whole scene.
  Eigen::Vector2d path_low_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d path_high_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_ = Eigen::Vector2d::Zero();
  double side_m_ = 4.0;
};

/// 8-bit BGR, dark; x to the right, z (forward) up; with a bar of a round number of metres. Positions that are not
/// finite are left out.
cv::Mat DrawTopView(const TopViewScene& scene, const TopViewWindow& window, const cv::Size& size);

}  // namespace plslam::viewer
