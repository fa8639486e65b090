// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/datasets/synthetic/texture.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"

namespace plslam::test {

/// A textured rectangle of a body, in the frame b of the body. Seen from outside, `s` points right and `t` down.
struct BodyFace {
  Eigen::Vector3d corner;
  Eigen::Vector3d s;  ///< whole side, metres
  Eigen::Vector3d t;
  size_t texture = 0;  ///< of the body
  double light = 1.0;
};

/// A convex rigid body: no face hides another one that is turned towards the camera.
struct Body {
  std::vector<BodyFace> faces;
  std::vector<synthetic::Texture> textures;
};

/// A box about the origin of b with the sides of `size_m` along x (right), y (down) and z (forward). The rear (towards
/// -z), left, right and front faces have the first texture, or each the next one if there are several; the roof has the
/// last one.
Body MakeBox(const Eigen::Vector3d& size_m, std::vector<synthetic::Texture> textures);

/// View of a body in a camera: grey values where `coverage` (0 to 1, CV_32F) is not 0.
struct BodyPicture {
  cv::Mat value;
  cv::Mat coverage;
};

/// Renders the body in the left camera of a rectified rig at `T_b_cam`, the pose of that camera in the body; for the
/// right camera, give its pose. Faces are filtered in the texture and anti-aliased at their borders.
BodyPicture PictureOfBody(const Body& body, const StereoCamera& camera, const SE3& T_b_cam);

/// Puts the picture in front of an image, with noise of `sigma` grey values on it, seeded.
void Paste(const BodyPicture& picture, double sigma, uint64_t seed, cv::Mat* image);

/// Adds noise of `sigma` grey values, seeded.
void AddNoise(double sigma, uint64_t seed, cv::Mat* image);

}  // namespace plslam::test
