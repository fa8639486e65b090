// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "core/motion/motion_estimator.h"

namespace plslam::test {

/// Points and segments in front of a stereo camera that moved by a known motion, measured with known noise. Segments
/// have new end points in the second view, as from a detector.
struct MotionWorld {
  StereoCamera camera{400.0, 320.0, 240.0, 0.12, 640, 480};
  SE3 T_cur_ref;
  std::vector<PointCorrespondence> points;
  std::vector<LineCorrespondence> lines;
};

struct MotionNoise {
  double measurement_px = 0.0;
  double disparity_px = 0.0;
  /// Noise of the stereo measurement from which the landmarks are created.
  double landmark_px = 0.0;
};

class MotionWorldMaker {
 public:
  explicit MotionWorldMaker(uint32_t seed) : random_(seed) {}

  MotionWorld Make(int n_points, int n_lines, const MotionNoise& noise);

  double Uniform(double from, double to) {
    return from + (to - from) * (static_cast<double>(random_()) / 4294967295.0);
  }
  double Gauss();
  Eigen::Vector3d GaussVector() { return {Gauss(), Gauss(), Gauss()}; }
  /// In the view of the camera, 2 to 8 m away.
  Eigen::Vector3d PointInView(const StereoCamera& camera);

  PointCorrespondence Observe(const MotionWorld& world, const Eigen::Vector3d& p_ref, const MotionNoise& noise);
  LineCorrespondence Observe(const MotionWorld& world, const Segment3& segment_ref, const MotionNoise& noise);
  SE3 SmallMotion(double translation_m, double rotation_rad);

 private:
  Eigen::Vector3d Measure(const StereoCamera& camera, const Eigen::Vector3d& p, double px, double disparity_px);

  std::mt19937 random_;
};

/// Error of an estimate as its covariance means it: x of T_ref_true * Exp(x) = T_ref_estimate.
inline Vector6d ErrorOf(const SE3& T_cur_ref_estimate, const SE3& T_cur_ref_true) {
  return (T_cur_ref_true * T_cur_ref_estimate.Inverse()).Log();
}

}  // namespace plslam::test
