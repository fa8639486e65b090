// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/calibrations/foreign_calibration.h"
#include "core/datasets/imu_parts.h"
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

// Inertial sensors, beside the cameras of the same formats (imu_settings.cpp). `notes` receives what is not used.

/// `T_cam_imu` or `T_imu_cam` of a camchain makes the sensor the body, and the time offset is that of the left camera
/// (`timeshift_cam_imu`: t_imu = t_cam + shift, https://github.com/ethz-asl/kalibr/wiki/yaml-formats; OpenVINS has the
/// same). Noise and rate are in the file that Kalibr and OpenVINS write beside it: the same name with `imu` for
/// `camchain-imucam` or `imu_chain` for `imucam_chain`, or else `imu.yaml`.
ImuParts ReadKalibrImu(const YamlMap& file, Notes* notes);
/// `IMU.T_b_c1` (before version 1.0: `Tbc`) transforms points from the left camera to the sensor. Densities are per
/// root of Hz: rad/s^0.5, m/s^1.5 and so on in the files that ORB_SLAM3 ships in Examples/Stereo-Inertial.
ImuParts ReadOrbSlamImu(const YamlMap& file, Notes* notes);
/// The body of `body_T_cam0` is the sensor. `td` is added to the time of an image for that of the sensor (comment in
/// config/euroc/euroc_stereo_imu_config.yaml of VINS-Fusion). Its noises are per sample, not per root of Hz, of a rate
/// that the file does not state (vins_estimator/src/factor/integration_base.h), and so not used.
ImuParts ReadVinsImu(const YamlMap& file, Notes* notes);
/// `T_imu_cam` makes the sensor the body. Noises are those of continuous time, and `cam_time_offset_ns` is added to the
/// time of an image (basalt-headers, include/basalt/calibration/calibration.hpp; basalt, src/vi_estimator).
ImuParts ReadBasaltImu(const YamlMap& file, Notes* notes);
/// OKVIS and OKVIS2: the S of `T_SC` is the sensor. Densities are per root of Hz; the delay of images is subtracted
/// from their time (comments in config/euroc.yaml of okvis2).
ImuParts ReadOkvisImu(const YamlMap& file, Notes* notes);
/// The body of `T_B_C` is the sensor. `delay_imu_cam` is subtracted from the time of an image; densities are per root
/// of Hz (rpg_svo_pro_open, svo_common/include/svo/common/imu_calibration.h, svo/src/imu_handler.cpp).
ImuParts ReadSvoImu(const YamlMap& file, Notes* notes);
/// The body of `T` is the sensor if `use_imu` is 1. Keys of the noise are Kalibr's (configs/camera of AirSLAM).
ImuParts ReadAirSlamImu(const YamlMap& file, Notes* notes);
/// Reads `ImuParams.yaml` beside the files of the cameras (params/Euroc of Kimera-VIO).
ImuParts ReadKimeraImu(const YamlMap& file, Notes* notes);

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
