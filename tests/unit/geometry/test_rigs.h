// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/geometry/calibration.h"

namespace plslam::test {

inline SE3 Pose(double qw, double qx, double qy, double qz, double x, double y, double z) {
  return SE3(Eigen::Quaterniond(qw, qx, qy, qz), {x, y, z});
}

/// As published in the sensor.yaml files of EuRoC MH_01_easy.
inline RigCalibration EurocRig() {
  RigCalibration rig;
  rig.name = "euroc";
  Eigen::Matrix3d left;
  left << 0.0148655429818, -0.999880929698, 0.00414029679422, 0.999557249008, 0.0149672133247, 0.025715529948,
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  Eigen::Matrix3d right;
  right << 0.0125552670891, -0.999755099723, 0.0182237714554, 0.999598781151, 0.0130119051815, 0.0251588363115,
      -0.0253898008918, 0.0179005838253, 0.999517347078;
  rig.left = {752,
              480,
              "radtan",
              458.654,
              457.296,
              367.215,
              248.375,
              {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
              SE3(left, {-0.0216401454975, -0.064676986768, 0.00981073058949})};
  rig.right = {752,
               480,
               "radtan",
               457.587,
               456.134,
               379.999,
               255.238,
               {-0.28368365, 0.07451284, -0.00010473, -3.55590700e-05},
               SE3(right, {-0.0198435579556, 0.0453689425024, 0.00786212447038})};
  return rig;
}

inline RigCalibration IdealRig() {
  RigCalibration rig;
  rig.name = "ideal";
  rig.left = {640, 480, "pinhole", 500.0, 500.0, 318.5, 241.5, {}, SE3()};
  rig.right = rig.left;
  rig.right.T_b_cam = SE3(Eigen::Quaterniond::Identity(), {0.1, 0.0, 0.0});
  return rig;
}

/// A fisheye pair like that of TUM VI (190 degrees), slightly toed out.
inline RigCalibration FisheyeRig() {
  RigCalibration rig;
  rig.name = "fisheye";
  rig.left = {512, 512, "equidistant", 190.98, 190.97, 254.93, 256.90, {0.0035, 0.0007, -0.0020, 0.0002}, SE3()};
  rig.right = {512, 512, "equidistant", 190.44, 190.43, 252.60, 254.92, {0.0034, 0.0018, -0.0027, 0.0003}, SE3()};
  rig.right.T_b_cam = SE3(ExpSO3({0.01, 0.04, -0.005}), {0.101, 0.002, 0.001});
  return rig;
}

/// As published for room1 of TUM VI, at half its resolution.
inline RigCalibration TumViRig() {
  RigCalibration rig;
  rig.name = "tumvi";
  Eigen::Matrix3d left;
  left << -0.999537825992, 0.007526588843, -0.029453096117, 0.029178072042, -0.034354931397, -0.99898367294,
      -0.008530798464, -0.999381353213, 0.034119442089;
  Eigen::Matrix3d right;
  right << -0.999524074749, 0.008095979458, -0.029767081032, 0.029867394853, 0.01256553461, -0.99947488516,
      -0.007717688852, -0.999888274987, -0.01280136017;
  rig.left = {512,
              512,
              "equidistant",
              190.405214357,
              190.405970897,
              254.897326524,
              256.915231527,
              {0.010171079892421483, -0.010816440029919381, 0.005942781769412756, -0.001662284667857643},
              SE3(left, {0.045379126901, -0.072677734786, -0.045072225337})};
  rig.right = {512,
               512,
               "equidistant",
               189.643494213,
               189.632918711,
               252.533335162,
               254.892048088,
               {0.01371679169245271, -0.015567360615942622, 0.00905043103315326, -0.002347858896562788},
               SE3(right, {-0.055521818638, -0.07110438059, -0.047834196459})};
  return rig;
}

inline RigCalibration RgbdRig() {
  RigCalibration rig;
  rig.name = "rgbd";
  rig.kind = RigCalibration::Kind::kRgbd;
  rig.left = {640, 480, "radtan", 517.3, 516.5, 318.6, 255.3, {0.2624, -0.9531, -0.0054, 0.0026, 1.1633}, SE3()};
  rig.right = rig.left;
  rig.depth_units_per_m = 5000.0;
  rig.baseline_m = 0.08;
  return rig;
}

}  // namespace plslam::test
