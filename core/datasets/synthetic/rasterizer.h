// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/datasets/synthetic/world.h"
#include "core/geometry/se3.h"

namespace plslam::synthetic {

/// Visible surfaces: those of a world, followed in numbering by moving ones at their pose in this view.
struct Scene {
  // NOLINTNEXTLINE(google-explicit-constructor): a world is a scene in which nothing moves.
  Scene(const World& still, std::vector<Quad> moving = {}) : world(&still), moved(std::move(moving)) {}

  int size() const { return static_cast<int>(world->quads().size() + moved.size()); }
  const Quad& quad(int i) const {
    const int still = static_cast<int>(world->quads().size());
    return i < still ? world->quads()[i] : moved[i - still];
  }

  const World* world;
  std::vector<Quad> moved;
};

/// A pinhole view without distortion. Pixel centres have integer coordinates.
struct View {
  int width = 0;
  int height = 0;
  double fx = 0.0;
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  /// World from camera (x right, y down, z forward).
  Eigen::Matrix3d R_w_c = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_w_c = Eigen::Vector3d::Zero();
};

/// a * x + b * y + c over pixels.
struct Linear {
  double a = 0.0;
  double b = 0.0;
  double c = 0.0;
  double At(double x, double y) const { return a * x + b * y + c; }
};

/// A quad in the image: all quantities are linear over the image, because s/z, t/z and 1/z are. No clipping is needed:
/// a point of the plane behind the camera never satisfies all four border conditions.
struct ScreenQuad {
  int quad = 0;
  int first_row = 0;
  int last_row = 0;
  Linear inverse_depth;
  Linear u;  ///< texel coordinate times inverse depth
  Linear v;
  /// Signed distances in pixels to the four borders, positive inside.
  std::array<Linear, 4> border;
  /// Greatest value of |a| dx + |b| dy over a pixel, for the borders and for the inverse depth.
  std::array<double, 4> border_half;
  double depth_half = 0.0;
};

/// The quads that may be seen in `view`.
std::vector<ScreenQuad> ProjectQuads(const Scene& scene, const View& view);

/// Which surface covers each pixel. Pixels crossed by a border hold a list of fragments beside the surface that
/// covers them whole.
struct Visibility {
  struct Fragment {
    int surface = -1;
    int next = -1;
  };
  int width = 0;
  int height = 0;
  std::vector<int> surface;          ///< index of the ScreenQuad that covers the whole pixel, or -1
  std::vector<float> inverse_depth;  ///< of that surface at the pixel's centre, or 0
  std::vector<int> first_fragment;   ///< index into `fragments`, or -1
  std::vector<Fragment> fragments;
};

Visibility FindVisible(const std::vector<ScreenQuad>& quads, int width, int height);

}  // namespace plslam::synthetic
