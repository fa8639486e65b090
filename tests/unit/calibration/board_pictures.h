// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <opencv2/core/mat.hpp>

#include "core/geometry/calibration.h"
#include "tools/calibration/rig_estimate.h"

namespace plslam::test {

/// A rig with known lenses (any model but "pinhole"), 640 x 480 px, baseline 0.12 m.
RigCalibration KnownRig(const std::string& model);

/// `n` poses of the board in the left camera: all over the image, near and far, tilted by up to 45 degrees.
std::vector<SE3> BoardPoses(const calibration::Board& board, int n, unsigned seed);

/// Returns the view of the board by a detector with noise of `sigma_px` in each coordinate, as far as it is in the
/// image.
calibration::BoardView SeenBoard(const calibration::Board& board, const CameraCalibration& camera,
                                 const SE3& T_camera_board, double sigma_px, unsigned seed);

/// A camera, and the rays (x, y at z = 1) of the corners of all its pixels.
struct CameraRays {
  CameraCalibration camera;
  std::vector<Eigen::Vector2d> corners;
  const Eigen::Vector2d& At(int u, int v) const {
    return corners[static_cast<size_t>(v * (camera.width_px + 1) + u)];
  }
};
CameraRays RaysOf(const CameraCalibration& camera);

/// The board as the camera sees it, on grey, 3 x 3 samples a pixel (rays are taken as linear within it), with noise
/// of `sigma` grey levels.
cv::Mat RenderBoard(const calibration::Board& board, const CameraRays& rays, const SE3& T_camera_board, double sigma,
                    unsigned seed);

}  // namespace plslam::test
