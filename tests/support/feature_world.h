// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "core/map/keyframe_features.h"

namespace plslam::test {

/// `change` gets the features of a keyframe and may leave others.
template <class Change>
void ChangeFeatures(KeyframeFeatures& features, KeyframeId keyframe_id, const Change& change) {
  StereoFeatures changed = OwnFeatures(features.at(keyframe_id));
  change(changed);
  features.at(keyframe_id) = std::move(changed);
}

/// A world of points and segments with unique descriptors, observed without images: stereo features of a perfect front
/// end, with Gaussian noise of the given sigmas.
class FeatureWorld {
 public:
  struct Counts {
    int points = 400;
    int lines = 80;
  };
  struct Point {
    Eigen::Vector3d p_w;
    Descriptor descriptor;
  };
  struct Line {
    Segment3 segment_w;
    Descriptor descriptor;
  };

  /// A shell of landmarks between 2 and 8 m around the origin.
  FeatureWorld(const Counts& counts, uint64_t seed);

  /// These landmarks, seen up to `max_depth_m` from the camera.
  FeatureWorld(std::vector<Point> points, std::vector<Line> lines, double max_depth_m);

  const std::vector<Point>& points() const { return points_; }
  const std::vector<Line>& lines() const { return lines_; }

  /// Returns the observations of a camera at `T_w_c`. `noise_px` is the sigma of each coordinate; 0 gives the exact
  /// projections.
  StereoFeatures Observe(const SE3& T_w_c, double noise_px, uint64_t seed) const;

  static StereoCamera Camera() { return {400.0, 320.0, 240.0, 0.12, 640, 480}; }

 private:
  std::vector<Point> points_;
  std::vector<Line> lines_;
  double max_depth_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace plslam::test
