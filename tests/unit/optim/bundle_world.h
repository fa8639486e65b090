// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "core/optim/bundle/bundle.h"

namespace plslam::test {

struct BundleWorldSpec {
  int fixed_poses = 2;
  int free_poses = 6;
  int points = 200;
  int lines = 60;
  /// Views of each landmark, by neighbouring poses.
  int observations = 5;
  double noise_px = 0.5;
  double noise_disparity_px = 0.4;
  /// Initial error of the poses; of landmarks the same, times their distance in metres.
  double start_m = 0.02;
  double start_rad = 0.005;
  /// Shares of all observations.
  double without_disparity = 0.0;
  double outliers = 0.0;
  /// Upright lines: along the camera's path they have no depth.
  bool upright = false;
};

/// A camera that moves sideways past points and segments, with measurements of the given noise. Segments have new end
/// points in each view, as from a detector.
struct BundleWorld {
  BundleProblem problem;
  std::vector<SE3> true_T_w_c;
  std::vector<Eigen::Vector3d> true_points;
  std::vector<Segment3> true_lines;
  std::vector<bool> point_outliers;
  std::vector<bool> line_outliers;
};

class BundleWorldMaker {
 public:
  BundleWorldMaker(const BundleWorldSpec& spec, uint32_t seed) : spec_(spec), random_(seed) {}

  BundleWorld Make();

  double Uniform(double from, double to) {
    return from + (to - from) * (static_cast<double>(random_()) / 4294967296.0);
  }
  double Gauss();
  Eigen::Vector3d GaussVector() { return {Gauss(), Gauss(), Gauss()}; }

 private:
  void MakePoses(BundleWorld& world);
  void MakePoint(BundleWorld& world);
  void MakeLine(BundleWorld& world);
  /// First of the neighbouring poses that see the next landmark.
  int FirstPose(const BundleWorld& world);
  Eigen::Vector3d PointInView(const SE3& T_w_c);
  Eigen::Vector3d Start(const Eigen::Vector3d& p_w, const SE3& T_w_c);
  /// (u, v, disparity) with noise; from anywhere in the image where `wrong`.
  Eigen::Vector3d Measure(const BundleWorld& world, int pose, const Eigen::Vector3d& p_w, bool wrong);
  /// The same with noise across the line only: where along it an end lies is chance anyway.
  void Measure(const BundleWorld& world, const Segment3& seen_w, bool wrong, LineObservation& observation);

  BundleWorldSpec spec_;
  std::mt19937 random_;
};

BundleWorld MakeBundleWorld(const BundleWorldSpec& spec, uint32_t seed);

/// Error of a pose as its covariance means it: x of T_true * Exp(x) = T.
inline Vector6d ErrorOf(const SE3& T, const SE3& T_true) { return (T_true.Inverse() * T).Log(); }

/// Distance of a point to the infinite line.
double DistanceToLine(const Eigen::Vector3d& p, const Segment3& line);

/// Root mean squares over free poses, points, and the true ends of lines.
struct BundleErrors {
  double translation_m = 0.0;
  double rotation_rad = 0.0;
  double point_m = 0.0;
  double line_m = 0.0;
};

BundleErrors ErrorsOf(const BundleWorld& world, const BundleResult& result);

}  // namespace plslam::test
