// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/files/notes.h"
#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// sensor_msgs/CameraInfo of ROS, of a message or of a file. K, P and the size are of the whole sensor; images may
/// be a part of it (`roi`, in pixels of the sensor) and have several of its pixels in one (`binning`).
struct RosCameraInfo {
  struct Roi {
    int x_px = 0, y_px = 0;
    int width_px = 0, height_px = 0;  ///< 0: the whole sensor

    bool operator==(const Roi&) const = default;
  };
  int width_px = 0, height_px = 0;
  std::string model;
  std::vector<double> distortion;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity(), R = Eigen::Matrix3d::Identity();
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();
  int binning_x = 1, binning_y = 1;  ///< 0 is 1
  Roi roi;

  bool operator==(const RosCameraInfo&) const = default;
};

/// Returns whether the name of an image topic says that its images are rectified: a part of the path is "rect" or
/// "rectified", or begins with "image_rect", as image_proc and drivers have it ("image_rect", "image_rect_color").
bool NamesRectified(std::string_view topic);

/// Warns if images are rectified by the name of their `topic`, and their camera_info has distortion, which is not
/// applied then. `remedy` follows "if they are not, ".
void WarnOfUnusedDistortion(const std::string& topic, const RosCameraInfo& info, const std::string& remedy,
                            Notes* notes);

/// The images that are delivered: those of the region of interest, binned.
ImageSize DeliveredSize(const RosCameraInfo& info);

/// K, P and size of the images as delivered, with neither binning nor region, as image_geometry of ROS derives them.
/// Drivers that bin in the camera announce binning, and calibrate the delivered images: if `images` have the size of
/// the complete sensor, K and P refer to it. `images` of 0 x 0: unknown size. Throws DatasetError if the region is
/// invalid, or `images` have neither size.
RosCameraInfo InPixelsOfImages(RosCameraInfo info, const ImageSize& images);

/// Returns one camera with K of its images (P if they are `rectified`), as that of an RGB-D camera. Throws DatasetError
/// if it is not calibrated (K or P all 0), or for lenses without an equivalent model here.
CameraCalibration CameraFromRos(const RosCameraInfo& info, bool rectified);

/// Returns the rig of two cameras with K and P of their images. Images are `rectified`: then P describes them;
/// otherwise K and D do, and R is the rotation of the cameras. The baseline is that of P, as in ROS (P[3] = -fx b, P[7]
/// of cameras one above the other). Throws DatasetError for cameras that are not calibrated (K or P all 0),
/// lenses without an equivalent model here, without a baseline or if it has the wrong sign, and if P is not that of a
/// rectified pair.
RigCalibration RigFromRos(const RosCameraInfo& left, const RosCameraInfo& right, bool rectified);

}  // namespace plslam
