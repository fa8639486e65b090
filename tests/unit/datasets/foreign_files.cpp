// SPDX-License-Identifier: BSD-3-Clause
#include "tests/unit/datasets/foreign_files.h"

namespace plslam::test {
namespace {

const char* const kKalibr = R"(cam0:
  cam_overlaps: [1]
  camera_model: pinhole
  distortion_coeffs: [-0.28, 0.07, 0.0002, -0.0001]
  distortion_model: radtan
  intrinsics: [458.5, 457.25, 335.5, 188.75]
  resolution: [672, 376]
  rostopic: /cam0/image_raw
cam1:
  T_cn_cnm1:
  - [0.9884965888, 0.0, -0.1512431616, -0.118619590656]
  - [0.0, 1.0, 0.0, -0.035]
  - [0.1512431616, 0.0, 0.9884965888, -0.018149179392]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: [0]
  camera_model: pinhole
  distortion_coeffs: [-0.27, 0.06, -0.0003, 0.0004]
  distortion_model: radtan
  intrinsics: [459.5, 458.25, 337.25, 186.5]
  resolution: [672, 376]
  rostopic: /cam1/image_raw
)";

const char* const kIntrinsics = R"(%YAML:1.0
---
image_width: 672
image_height: 376
M1: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 458.5, 0., 335.5, 0., 457.25, 188.75, 0., 0., 1. ]
D1: !!opencv-matrix
   rows: 1
   cols: 14
   dt: d
   data: [ -0.28, 0.07, 0.0002, -0.0001, 0., 0., 0., 0., 0., 0., 0., 0., 0., 0. ]
M2: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 459.5, 0., 337.25, 0., 458.25, 186.5, 0., 0., 1. ]
D2: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -0.27, 0.06, -0.0003, 0.0004, 0. ]
)";

const char* const kExtrinsics = R"(%YAML:1.0
---
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 0.9884965888, 0., -0.1512431616, 0., 1., 0., 0.1512431616, 0., 0.9884965888 ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -0.118619590656, -0.035, -0.018149179392 ]
)";

const char* const kRosLeft = R"(image_width: 672
image_height: 376
camera_name: left
camera_matrix:
  rows: 3
  cols: 3
  data: [458.5, 0, 335.5, 0, 457.25, 188.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-0.28, 0.07, 0.0002, -0.0001, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [0.96, 0.28, 0, -0.28, 0.96, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [400, 0, 330, 0, 0, 400, 190, 0, 0, 0, 1, 0]
)";

// As a ROS 2 message prints.
const char* const kRosRight = R"(height: 376
width: 672
distortion_model: rational_polynomial
d: [-0.27, 0.06, -0.0003, 0.0004, 0.0, 0.0, 0.0, 0.0]
k: [459.5, 0.0, 337.25, 0.0, 458.25, 186.5, 0.0, 0.0, 1.0]
r: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
p: [400.0, 0.0, 330.0, -50.0, 0.0, 400.0, 190.0, 0.0, 0.0, 0.0, 1.0, 0.0]
)";

const char* const kOrbSlam2 = R"(%YAML:1.0
Camera.fx: 400.0
Camera.fy: 400.0
Camera.cx: 330.0
Camera.cy: 190.0
Camera.k1: 0.0
Camera.width: 672
Camera.height: 376
Camera.fps: 20.0
Camera.bf: 50.0
ThDepth: 35
LEFT.height: 376
LEFT.width: 672
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
LEFT.R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
RIGHT.D: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [-0.27, 0.06, -0.0003, 0.0004, 0.0]
RIGHT.K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [459.5, 0.0, 337.25, 0.0, 458.25, 186.5, 0.0, 0.0, 1.0]
RIGHT.R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
ORBextractor.nFeatures: 1200
)";

const char* const kOrbSlam3 = R"(%YAML:1.0
File.version: "1.0"
Camera.type: "PinHole"
Camera1.fx: 458.5
Camera1.fy: 457.25
Camera1.cx: 335.5
Camera1.cy: 188.75
Camera1.k1: -0.28
Camera1.k2: 0.07
Camera1.p1: 0.0002
Camera1.p2: -0.0001
Camera2.fx: 459.5
Camera2.fy: 458.25
Camera2.cx: 337.25
Camera2.cy: 186.5
Camera2.k1: -0.27
Camera2.k2: 0.06
Camera2.p1: -0.0003
Camera2.p2: 0.0004
Camera.width: 672
Camera.height: 376
Camera.fps: 20
Stereo.ThDepth: 60.0
Stereo.T_c1_c2: !!opencv-matrix
  rows: 4
  cols: 4
  dt: f
  data: [0.9884965888, 0.0, 0.1512431616, 0.12, 0.0, 1.0, 0.0, 0.035, -0.1512431616, 0.0, 0.9884965888, 0.0, 0, 0, 0, 1.0]
)";

const char* const kStella = R"(Camera:
  name: "by hand"
  setup: "stereo"
  model: "perspective"
  fx: 400.0
  fy: 400.0
  cx: 330.0
  cy: 190.0
  k1: 0.0
  fps: 20.0
  cols: 672
  rows: 376
  focal_x_baseline: 50.0
  color_order: "Gray"
StereoRectifier:
  model: "perspective"
  K_left: [458.5, 0.0, 335.5, 0.0, 457.25, 188.75, 0.0, 0.0, 1.0]
  D_left: [-0.28, 0.07, 0.0002, -0.0001, 0.0]
  R_left: [0.96, 0.28, 0.0, -0.28, 0.96, 0.0, 0.0, 0.0, 1.0]
  K_right: [459.5, 0.0, 337.25, 0.0, 458.25, 186.5, 0.0, 0.0, 1.0]
  D_right: [-0.27, 0.06, -0.0003, 0.0004, 0.0]
  R_right: [0.948956725248, 0.28, 0.145193435136, -0.276779044864, 0.96, -0.042348085248, -0.1512431616, 0.0, 0.9884965888]
)";

const char* const kBasalt = R"({
    "value0": {
        "T_imu_cam": [
            {"px": 0.0, "py": 0.0, "pz": 0.0, "qx": 0.0, "qy": 0.0, "qz": 0.0, "qw": 1.0},
            {"px": 0.12, "py": 0.035, "pz": 0.0, "qx": 0.0, "qy": 0.07584, "qz": 0.0, "qw": 0.99712}
        ],
        "intrinsics": [
            {"camera_type": "pinhole-radtan8",
             "intrinsics": {"fx": 458.5, "fy": 457.25, "cx": 335.5, "cy": 188.75, "k1": -0.28, "k2": 0.07, "p1": 0.0002,
                            "p2": -0.0001, "k3": 0.0, "k4": 0.0, "k5": 0.0, "k6": 0.0, "rpmax": 0.0}},
            {"camera_type": "pinhole-radtan8",
             "intrinsics": {"fx": 459.5, "fy": 458.25, "cx": 337.25, "cy": 186.5, "k1": -0.27, "k2": 0.06, "p1": -0.0003,
                            "p2": 0.0004, "k3": 0.0, "k4": 0.0, "k5": 0.0, "k6": 0.0, "rpmax": 0.0}}
        ],
        "resolution": [[672, 376], [672, 376]],
        "imu_update_rate": 200.0
    }
}
)";

const char* const kZed = R"([LEFT_CAM_HD]
fx=700
fy=700

[LEFT_CAM_VGA]
fx=458.5
fy=457.25
cx=335.5
cy=188.75
k1=-0.28
k2=0.07
p1=0.0002
p2=-0.0001
k3=0

[RIGHT_CAM_VGA]
fx=459.5
fy=458.25
cx=337.25
cy=186.5
k1=-0.27
k2=0.06
p1=-0.0003
p2=0.0004
k3=0

[STEREO]
Baseline=118.619590656
TY_VGA=35
TZ_VGA=18.149179392
RX_VGA=0
CV_VGA=-0.1518257807532574
RZ_VGA=0
)";

}  // namespace

const std::vector<ForeignRig>& ForeignRigs() {
  static const std::vector<ForeignRig> rigs = [] {
    std::vector<ForeignRig> all{{"Kalibr camchain", {{"camchain.yaml", kKalibr}}},
                                {"OpenCV stereo", {{"intrinsics.yml", kIntrinsics}, {"extrinsics.yml", kExtrinsics}}},
                                {"ROS camera_info", {{"left.yaml", kRosLeft}, {"right.yaml", kRosRight}}},
                                {"ORB-SLAM", {{"orb_slam2.yaml", kOrbSlam2}}},
                                {"ORB-SLAM", {{"orb_slam3.yaml", kOrbSlam3}}},
                                {"stella_vslam", {{"stella.yaml", kStella}}},
                                {"Basalt", {{"basalt.json", kBasalt}}},
                                {"ZED", {{"SN1234.conf", kZed}}}};
    const std::vector<ForeignRig> settings = SlamSettings();
    all.insert(all.end(), settings.begin(), settings.end());
    return all;
  }();
  return rigs;
}

}  // namespace plslam::test
