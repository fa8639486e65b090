// SPDX-License-Identifier: BSD-3-Clause
// The settings of SLAM programs, as their authors ship them, with the numbers of ForeignRigs().
#include "tests/unit/datasets/foreign_files.h"

namespace plslam::test {
namespace {

// OpenVINS: the body is an IMU whose axes are those of the left camera, which is at (0.5, 0.25, 0) in it.
const char* const kOpenVins = R"(%YAML:1.0
cam0:
  T_imu_cam:
    - [1.0, 0.0, 0.0, 0.5]
    - [0.0, 1.0, 0.0, 0.25]
    - [0.0, 0.0, 1.0, 0.0]
    - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, -0.0001]
  distortion_model: radtan
  intrinsics: [458.5, 457.25, 335.5, 188.75]
  resolution: [672, 376]
cam1:
  T_imu_cam:
    - [0.9884965888, 0.0, 0.1512431616, 0.62]
    - [0.0, 1.0, 0.0, 0.285]
    - [-0.1512431616, 0.0, 0.9884965888, 0.0]
    - [0.0, 0.0, 0.0, 1.0]
  camera_model: pinhole
  distortion_coeffs: [-0.27, 0.06, -0.0003, 0.0004]
  distortion_model: radtan
  intrinsics: [459.5, 458.25, 337.25, 186.5]
  resolution: [672, 376]
)";

// Files of ORB-SLAM2 are shipped like this: some lines have no blank after the colon.
const char* const kOrbSlam2WithoutBlanks = R"(%YAML:1.0
Camera.fx: 400.0
Camera.fy: 400.0
Camera.cx: 330.0
Camera.cy: 190.0
Camera.bf:50.0
Camera.fps: 20.0
LEFT.height: 376
LEFT.width: 672
LEFT.D: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data:[-0.28, 0.07, 0.0002, -0.0001, 0.0]
LEFT.K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [458.5, 0.0, 335.5, 0.0, 457.25, 188.75, 0.0, 0.0, 1.0]
LEFT.R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
LEFT.P:  !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [400.0, 0, 330.0, 0,  0, 400.0, 190.0, 0,  0, 0, 1, 0]
RIGHT.D: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data:[-0.27, 0.06, -0.0003, 0.0004, 0.0]
RIGHT.K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [459.5, 0.0, 337.25, 0.0, 458.25, 186.5, 0.0, 0.0, 1]
RIGHT.R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
Viewer.PointSize:2
Viewer.ViewpointX: 0
)";

// ORB-SLAM3 before version 1.0.
const char* const kOrbSlamTlr = R"(%YAML:1.0
Camera.type: "PinHole"
Camera.fx: 458.5
Camera.fy: 457.25
Camera.cx: 335.5
Camera.cy: 188.75
Camera.k1: -0.28
Camera.k2: 0.07
Camera.p1: 0.0002
Camera.p2: -0.0001
Camera2.fx: 459.5
Camera2.fy: 458.25
Camera2.cx: 337.25
Camera2.cy: 186.5
Camera2.k1: -0.27
Camera2.k2: 0.06
Camera2.p1: -0.0003
Camera2.p2: 0.0004
Tlr: !!opencv-matrix
  rows: 3
  cols: 4
  dt: f
  data: [0.9884965888, 0.0, 0.1512431616, 0.12, 0.0, 1.0, 0.0, 0.035, -0.1512431616, 0.0, 0.9884965888, 0.0]
Camera.width: 672
Camera.height: 376
Camera.bf: 57.3
)";

// OpenVSLAM, before the keys of stella_vslam went below others.
const char* const kOpenVslam = R"(Camera.name: "by hand"
Camera.setup: "stereo"
Camera.model: "perspective"
Camera.fx: 400.0
Camera.fy: 400.0
Camera.cx: 330.0
Camera.cy: 190.0
Camera.k1: 0.0
Camera.fps: 20.0
Camera.cols: 672
Camera.rows: 376
Camera.focal_x_baseline: 50.0
StereoRectifier.model: "perspective"
StereoRectifier.K_left: [458.5, 0.0, 335.5, 0.0, 457.25, 188.75, 0.0, 0.0, 1.0]
StereoRectifier.D_left: [-0.28, 0.07, 0.0002, -0.0001, 0.0]
StereoRectifier.R_left: [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
StereoRectifier.K_right: [459.5, 0.0, 337.25, 0.0, 458.25, 186.5, 0.0, 0.0, 1.0]
StereoRectifier.D_right: [-0.27, 0.06, -0.0003, 0.0004, 0.0]
StereoRectifier.R_right: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
)";

const char* const kPlSlam = R"(cam0:
  Kl: [458.5, 457.25, 335.5, 188.75]
  Kr: [459.5, 458.25, 337.25, 186.5]
  Dl: [-0.28, 0.07, 0.0002, -0.0001]
  Dr: [-0.27,  0.06, -0.0003, 0.0004]
  cam_bl: 0.125
  cam_height: 376
  cam_model: Pinhole
  cam_width: 672
  R: [ 0.9884965888, 0.0, -0.1512431616,
	0.0, 1.0, 0.0,
	0.1512431616, 0.0, 0.9884965888 ]
  t: [ -0.118619590656, -0.035, -0.018149179392 ]
images_subfolder_l: left/
images_subfolder_r: right/
)";

// PL-SLAM's first version: rotations that rectify.
const char* const kPlSlamRectifying = R"(cam0:
  Kl: [458.5, 457.25, 335.5, 188.75]
  Kr: [459.5, 458.25, 337.25, 186.5]
  cam_bl: 0.125
  cam_height: 376
  cam_model: Pinhole
  cam_width: 672
  Rl: [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
  Rr: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
  Dl: [-0.28, 0.07, 0.0002, -0.0001]
  Dr: [-0.27, 0.06, -0.0003, 0.0004]
)";

const char* const kAirSlam = R"(%YAML:1.0
image_height: 376
image_width: 672
use_imu: 1
distortion_type: 1
cam0:
  intrinsics: [458.5, 457.25, 335.5, 188.75]
  distortion_coeffs: [-0.28, 0.07, 0.0002, -0.0001, 0]
  T_type: 0
  T:
  - [1.0, 0.0, 0.0, 0.0]
  - [0.0, 1.0, 0.0, 0.0]
  - [0.0, 0.0, 1.0, 0.0]
  - [0.0, 0.0, 0.0, 1.0]
cam1:
  intrinsics: [459.5, 458.25, 337.25, 186.5]
  distortion_coeffs: [-0.27, 0.06, -0.0003, 0.0004, 0]
  T_type: 1
  T:
  - [0.9884965888, 0.0, -0.1512431616, -0.118619590656]
  - [0.0, 1.0, 0.0, -0.035]
  - [0.1512431616, 0.0, 0.9884965888, -0.018149179392]
  - [0.0, 0.0, 0.0, 1.0]
rate_hz: 200
)";

const char* const kEarlyAirSlam = R"(%YAML:1.0
image_height: 376
image_width: 672
bf: 50.0
distortion_type: 0
LEFT.D: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [-0.28, 0.07, 0.0002, -0.0001, 0.0]
LEFT.K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [458.5, 0.0, 335.5, 0.0, 457.25, 188.75, 0.0, 0.0, 1.0]
LEFT.R:  !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
LEFT.P:  !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [400.0, 0, 330.0, 0,  0, 400.0, 190.0, 0,  0, 0, 1, 0]
RIGHT.D: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [-0.27, 0.06, -0.0003, 0.0004, 0.0]
RIGHT.K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [459.5, 0.0, 337.25, 0.0, 458.25, 186.5, 0.0, 0.0, 1]
RIGHT.R:  !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
RIGHT.P:  !!opencv-matrix
   rows: 3
   cols: 4
   dt: d
   data: [400.0, 0, 330.0, -50.0,  0, 400.0, 190.0, 0,  0, 0, 1, 0]
)";

const char* const kKimeraLeft = R"(%YAML:1.0
camera_id: left_cam
T_BS:
  cols: 4
  rows: 4
  data: [1.0, 0.0, 0.0, 0.5,
         0.0, 1.0, 0.0, 0.0,
         0.0, 0.0, 1.0, 0.0,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [672, 376]
camera_model: pinhole
intrinsics: [458.5, 457.25, 335.5, 188.75] #fu, fv, cu, cv
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, -0.0001]
)";

const char* const kKimeraRight = R"(%YAML:1.0
camera_id: right_cam
T_BS:
  cols: 4
  rows: 4
  data: [0.9884965888, 0.0, 0.1512431616, 0.62,
         0.0, 1.0, 0.0, 0.035,
         -0.1512431616, 0.0, 0.9884965888, 0.0,
         0.0, 0.0, 0.0, 1.0]
rate_hz: 20
resolution: [672, 376]
camera_model: pinhole
intrinsics: [459.5, 458.25, 337.25, 186.5]
distortion_model: radial-tangential
distortion_coefficients: [-0.27, 0.06, -0.0003, 0.0004]
)";

const char* const kOkvis = R"(%YAML:1.0
cameras:
     - {T_SC:
        [ 1.0, 0.0, 0.0, 0.0,
          0.0, 1.0, 0.0, 0.0,
          0.0, 0.0, 1.0, 0.0,
          0.0, 0.0, 0.0, 1.0 ],
        image_dimension: [672, 376],
        distortion_coefficients: [-0.28, 0.07, 0.0002, -0.0001],
        distortion_type: radialtangential,
        focal_length: [458.5, 457.25],
        principal_point: [335.5, 188.75]}

     - {T_SC:
        [ 0.9884965888, 0.0, 0.1512431616, 0.12,
          0.0, 1.0, 0.0, 0.035,
          -0.1512431616, 0.0, 0.9884965888, 0.0,
          0.0, 0.0, 0.0, 1.0 ],
        image_dimension: [672, 376],
        distortion_coefficients: [-0.27, 0.06, -0.0003, 0.0004],
        distortion_type: radialtangential,
        focal_length: [459.5, 458.25],
        principal_point: [337.25, 186.5],
        camera_type: gray, #gray, rgb, gray+depth, rgb+depth
        slam_use: okvis}
camera_params:
    camera_rate: 20
)";

const char* const kSvo = R"(label: "by hand"
cameras:
- camera:
    label: cam0
    line-delay-nanoseconds: 0
    image_height: 376
    image_width: 672
    type: pinhole
    intrinsics:
      cols: 1
      rows: 4
      data: [458.5, 457.25, 335.5, 188.75]
    distortion:
      type: radial-tangential
      parameters:
        cols: 1
        rows: 4
        data: [-0.28, 0.07, 0.0002, -0.0001]
  T_B_C:
    cols: 4
    rows: 4
    data: [1., 0., 0., 0.,
           0., 1., 0., 0.,
           0., 0., 1., 0.,
           0., 0., 0., 1.]
- camera:
    label: cam1
    image_height: 376
    image_width: 672
    type: pinhole
    intrinsics:
      cols: 1
      rows: 4
      data: [459.5, 458.25, 337.25, 186.5]
    distortion:
      type: radial-tangential
      parameters:
        cols: 1
        rows: 4
        data: [-0.27, 0.06, -0.0003, 0.0004]
  T_B_C:
    cols: 4
    rows: 4
    data: [0.9884965888, 0.0, 0.1512431616, 0.12,
           0.0, 1.0, 0.0, 0.035,
           -0.1512431616, 0.0, 0.9884965888, 0.0,
           0., 0., 0., 1.]
)";

const char* const kVins = R"(%YAML:1.0
imu: 1
num_of_cam: 2
imu_topic: "/imu0"
output_path: "/home/user/output/"
cam0_calib: "cam0_pinhole.yaml"
cam1_calib: "cam1_pinhole.yaml"
image_width: 672
image_height: 376
body_T_cam0: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [1.0, 0.0, 0.0, 0.0,
          0.0, 1.0, 0.0, 0.5,
          0.0, 0.0, 1.0, 0.0,
          0, 0, 0, 1]
body_T_cam1: !!opencv-matrix
   rows: 4
   cols: 4
   dt: d
   data: [0.9884965888, 0.0, 0.1512431616, 0.12,
          0.0, 1.0, 0.0, 0.535,
          -0.1512431616, 0.0, 0.9884965888, 0.0,
          0, 0, 0, 1]
)";

const char* const kCamodocalLeft = R"(%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 672
image_height: 376
distortion_parameters:
   k1: -0.28
   k2: 0.07
   p1: 0.0002
   p2: -0.0001
projection_parameters:
   fx: 458.5
   fy: 457.25
   cx: 335.5
   cy: 188.75
)";

const char* const kCamodocalRight = R"(%YAML:1.0
---
model_type: PINHOLE
camera_name: camera
image_width: 672
image_height: 376
distortion_parameters:
   k1: -0.27
   k2: 0.06
   p1: -0.0003
   p2: 0.0004
projection_parameters:
   fx: 459.5
   fy: 458.25
   cx: 337.25
   cy: 186.5
)";

const char* const kDepthAi = R"({
  "boardName": "BW1098OBC",
  "cameraData": [
    [0, {"cameraType": 0, "distortionCoeff": [], "extrinsics": {"rotationMatrix": [], "toCameraSocket": -1}}],
    [1, {"cameraType": 0,
         "distortionCoeff": [-0.28, 0.07, 0.0002, -0.0001, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
         "extrinsics": {"rotationMatrix": [[0.9884965888, 0.0, -0.1512431616], [0.0, 1.0, 0.0],
                                           [0.1512431616, 0.0, 0.9884965888]],
                        "specTranslation": {"x": -12.0, "y": 0.0, "z": 0.0}, "toCameraSocket": 2,
                        "translation": {"x": -11.8619590656, "y": -3.5, "z": -1.8149179392}},
         "height": 376, "width": 672, "lensPosition": 0, "specHfovDeg": 71.86,
         "intrinsicMatrix": [[458.5, 0.0, 335.5], [0.0, 457.25, 188.75], [0.0, 0.0, 1.0]]}],
    [2, {"cameraType": 0,
         "distortionCoeff": [-0.27, 0.06, -0.0003, 0.0004, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
         "extrinsics": {"rotationMatrix": [], "toCameraSocket": -1, "translation": {"x": 0.0, "y": 0.0, "z": 0.0}},
         "height": 376, "width": 672,
         "intrinsicMatrix": [[459.5, 0.0, 337.25], [0.0, 458.25, 186.5], [0.0, 0.0, 1.0]]}]
  ],
  "stereoRectificationData": {"leftCameraSocket": 1, "rightCameraSocket": 2}
}
)";

}  // namespace

std::vector<ForeignRig> SlamSettings() {
  return {{"Kalibr camchain", {{"openvins.yaml", kOpenVins}}},
          {"ORB-SLAM", {{"orb_slam2_no_blanks.yaml", kOrbSlam2WithoutBlanks}}},
          {"ORB-SLAM", {{"orb_slam_tlr.yaml", kOrbSlamTlr}}},
          {"stella_vslam", {{"openvslam.yaml", kOpenVslam}}},
          {"PL-SLAM", {{"pl_slam.yaml", kPlSlam}}},
          {"PL-SLAM", {{"pl_slam_rectifying.yaml", kPlSlamRectifying}}},
          {"AirSLAM", {{"airslam.yaml", kAirSlam}}},
          {"AirSLAM", {{"early_airslam.yaml", kEarlyAirSlam}}},
          {"Kimera", {{"LeftCameraParams.yaml", kKimeraLeft}, {"RightCameraParams.yaml", kKimeraRight}}},
          {"OKVIS", {{"okvis.yaml", kOkvis}}},
          {"SVO", {{"svo.yaml", kSvo}}},
          {"VINS-Fusion",
           {{"vins.yaml", kVins}},
           {{"cam0_pinhole.yaml", kCamodocalLeft}, {"cam1_pinhole.yaml", kCamodocalRight}}},
          {"DepthAI", {{"depthai.json", kDepthAi}}}};
}

}  // namespace plslam::test
