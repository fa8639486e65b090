// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// sensor_msgs/CameraInfo of ROS, of a message or of a file. K, P and the size are of the whole sensor; images may
/// be a part of it (`roi`, in pixels of the sensor) and have several of its pixels in one (`binning`).
struct RosCameraInfo {
  struct Roi {
    int x_px = 0, y_px = 0;
    int width_px = 0, height_px = 0;  ///< 0: the whole sensor
  };
  int width_px = 0, height_px = 0;
  std::string model;
  std::vector<double> distortion;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity(), R = Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
  int binning_x = 1, binning_y = 1;  ///< 0 is 1
  Roi roi;
};

/// The images that are delivered: those of the region of interest, binned.
ImageSize DeliveredSize(const RosCameraInfo& info);

/// K, P and size of the images as delivered, with neither binning nor region, as image_geometry of ROS derives them.
/// Drivers that bin in the camera announce binning, and calibrate what they deliver: where `images` have the size of
/// the whole sensor, K and P are theirs. `images` of 0 x 0 are not known. Throws DatasetError where the region is
/// none, or where `images` have another size than both.
RosCameraInfo InPixelsOfImages(RosCameraInfo info, const ImageSize& images);

/// The rig of two cameras with K and P of their images. Images are `rectified`: then P describes them, else K and D
/// do, and R tells how the cameras are turned. The baseline is that of P, where ROS has it (P[3] = -fx b, P[7] of
/// cameras one above the other). Throws DatasetError for lenses that have no counterpart here, where there is no
/// baseline, and where P is not that of a rectified pair.
RigCalibration RigFromRos(const RosCameraInfo& left, const RosCameraInfo& right, bool rectified);

}  // namespace plslam
