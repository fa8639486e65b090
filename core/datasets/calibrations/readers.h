// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/yaml_map.h"

namespace plslam {

// One for each format. All throw DatasetError. Their caller checks the rig as a whole (RigComplaint); they use
// `image_size` if the file has no size.

/// Reads settings of PL-SLAM, the paper's own program: `cam0` with both cameras in it.
ForeignCalibration ReadPlSlam(const YamlMap& file);
ForeignCalibration ReadAirSlam(const YamlMap& file, const ImageSize& image_size);
ForeignCalibration ReadKalibr(const YamlMap& file);
/// Reads the files of Kimera: a `sensor.yaml` of the ASL format for each camera.
ForeignCalibration ReadAslPair(const std::vector<YamlMap>& files);
/// Keys may be in either of the files, as OpenCV's stereo_calib example writes separate files of intrinsics and
/// extrinsics.
ForeignCalibration ReadOpenCv(const std::vector<YamlMap>& files, const ImageSize& image_size);
ForeignCalibration ReadRos(const std::vector<YamlMap>& files, const ImageSize& image_size);
/// Reads settings of ORB-SLAM2 and 3, of a stereo pair or an RGB-D camera.
ForeignCalibration ReadOrbSlam(const YamlMap& file, const ImageSize& image_size);
/// Reads settings of a stereo pair or an RGB-D camera.
ForeignCalibration ReadStella(const YamlMap& file, const ImageSize& image_size);
ForeignCalibration ReadBasalt(const YamlMap& file);
/// Reads settings of OKVIS and OKVIS2.
ForeignCalibration ReadOkvis(const YamlMap& file);
ForeignCalibration ReadSvo(const YamlMap& file);
/// Settings of VINS-Fusion, with the files of both cameras that they name.
ForeignCalibration ReadVins(const YamlMap& file);
ForeignCalibration ReadDepthAi(const YamlMap& file);
ForeignCalibration ReadZed(const std::string& path, const ImageSize& image_size);

bool LooksLikeOpenCv(const YamlMap& file);
bool LooksLikeRos(const YamlMap& file);

// Helpers that several readers share.

/// A smaller skew is the rounding of a solver.
inline constexpr double kNoSkew_px = 1e-6;
/// Reads a camera matrix of 9 numbers, whose skew must be 0 (kNoSkew_px).
void SetCameraMatrix(const YamlMap& yaml, const char* key, CameraCalibration* camera);

/// Reads distortion in OpenCV's order: 4 or 5 numbers are "radtan", 8 "rational" ("radtan" if the divisor's are 0), 12
/// and 14 the same if the rest is 0, and zeros "pinhole".
void SetOpenCvDistortion(const YamlMap& yaml, const char* key, CameraCalibration* camera);
/// Sets coefficients from another source; returns an error, or an empty string.
std::string SetOpenCvDistortion(std::vector<double> coefficients, CameraCalibration* camera);

/// A camera of a file of several: its name in errors ("cam0"), and the topic of its images, empty if unknown.
struct NamedCamera {
  std::string name;
  std::string topic;
  CameraCalibration camera;
};

/// Indices of the stereo pair of a file. Among more than two cameras, the pair is the two whose topics are called left
/// and right (infra1 and infra2), or else the only two that are side by side with equal lenses; `note` names them.
/// Throws DatasetError at `place` if there is no pair, or several possible ones.
struct CameraPair {
  size_t left = 0, right = 1;
  std::string note;
};
CameraPair ChoosePair(const std::vector<NamedCamera>& cameras, const std::string& place);

/// Reads fx, fy, cx and cy, whose keys begin with `prefix`.
void SetFocalAndCentre(const YamlMap& file, const std::string& prefix, CameraCalibration* camera);

/// Width and height of both cameras.
void SetSize(const ImageSize& size, RigCalibration* rig);

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
