// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

namespace plslam::synthetic {

/// Maps the pixels of a distorted image to those of an ideal pinhole image that is rendered larger, and fetches them.
class Lens {
 public:
  struct Intrinsics {
    double fx = 0.0;
    double fy = 0.0;
    double cx = 0.0;
    double cy = 0.0;
    int width = 0;
    int height = 0;
  };

  Lens() = default;
  /// A lens without distortion.
  explicit Lens(const Intrinsics& intrinsics) : recorded_(intrinsics), ideal_(intrinsics) {}
  /// Radial-tangential distortion k1 k2 p1 p2 (as in OpenCV).
  Lens(const Intrinsics& intrinsics, const std::array<double, 4>& k);

  const Intrinsics& recorded() const { return recorded_; }
  /// The pinhole view to render.
  const Intrinsics& ideal() const { return ideal_; }
  const std::array<double, 4>& distortion() const { return k_; }
  bool is_distorted() const { return !map_.empty(); }

  /// The recorded image from the ideal one: the mean of four bilinear fetches from a picture of finer pixels.
  std::vector<float> Apply(const std::vector<float>& ideal) const;

 private:
  struct Source {
    float x = 0.0F;
    float y = 0.0F;
  };

  Intrinsics recorded_;
  Intrinsics ideal_;
  std::array<double, 4> k_ = {};
  std::vector<Source> map_;
};

/// A distortion of a pair of lenses that the calibration lacks: disparity errors that form a parabola over the columns
/// of the left image, given at the centres of its left, middle and right third.
class DisparityBias {
 public:
  DisparityBias(const std::array<double, 3>& thirds_px, int width) : thirds_px_(thirds_px), width_(width) {}

  bool is_zero() const { return thirds_px_ == std::array<double, 3>{}; }
  double At(double u_px) const;

  /// Applies the errors to the right image: its pixels are moved by the error of the columns in which the left camera
  /// sees the same points. These follow from `depth_m` of the right image (0: infinitely far) and f b.
  std::vector<float> Apply(const std::vector<float>& right, const std::vector<float>& depth_m,
                           double focal_baseline) const;

 private:
  std::array<double, 3> thirds_px_;
  int width_ = 0;
};

}  // namespace plslam::synthetic
