// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/yaml_map.h"

namespace plslam {

// One for each format. All throw DatasetError. They leave checks of the rig as a whole (RigComplaint) to their
// caller, and take `image_size` where the file does not tell one.

ForeignCalibration ReadKalibr(const YamlMap& file);
/// Keys may stand in either of the files, as the stereo_calib example of OpenCV writes intrinsics and extrinsics
/// apart.
ForeignCalibration ReadOpenCv(const std::vector<YamlMap>& files, const ImageSize& image_size);
ForeignCalibration ReadRos(const std::vector<YamlMap>& files);
ForeignCalibration ReadOrbSlam(const YamlMap& file, const ImageSize& image_size);
ForeignCalibration ReadStella(const YamlMap& file, const ImageSize& image_size);
ForeignCalibration ReadBasalt(const YamlMap& file);
ForeignCalibration ReadZed(const std::string& path, const ImageSize& image_size);

// What several of them share.

/// A camera matrix of 9 numbers, whose skew must be 0.
void SetCameraMatrix(const YamlMap& yaml, const char* key, CameraCalibration* camera);

/// Distortion in OpenCV's order: 4 or 5 numbers are "radtan", 8 "rational" ("radtan" where the divisor's are 0), 12
/// and 14 the same where the rest is 0, and zeros "pinhole".
void SetOpenCvDistortion(const YamlMap& yaml, const char* key, CameraCalibration* camera);
/// The same of numbers from elsewhere: a complaint, or nothing.
std::string SetOpenCvDistortion(std::vector<double> coefficients, CameraCalibration* camera);

/// A rotation of 9 numbers.
Eigen::Matrix3d RotationOf(const YamlMap& yaml, const char* key);

/// Left from right camera, from the rotations that rectify each (to a rectified frame from its camera) and the
/// baseline.
SE3 LeftFromRight(const Eigen::Matrix3d& R_left, const Eigen::Matrix3d& R_right, double baseline_m);

/// Moved along +x, unturned.
SE3 AlongX(double x_m);

/// A whole number of pixels.
int PixelsOf(const YamlMap& yaml, const char* key);

/// The rig with the left camera as its body.
RigCalibration RigOf(const CameraCalibration& left, const CameraCalibration& right, const SE3& T_left_right);

}  // namespace plslam
