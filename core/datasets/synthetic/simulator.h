// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/datasets/dataset.h"
#include "core/datasets/synthetic/bodies.h"
#include "core/datasets/synthetic/distortion.h"
#include "core/datasets/synthetic/motion.h"
#include "core/datasets/synthetic/options.h"
#include "core/datasets/synthetic/renderer.h"
#include "core/datasets/synthetic/sensor.h"
#include "core/datasets/synthetic/weather.h"
#include "core/datasets/synthetic/world.h"
#include "core/geometry/calibration.h"
#include "core/geometry/se3.h"
#include "core/io/images/image_file.h"

namespace plslam::synthetic {

/// A stereo camera moved through a synthetic world. Every frame depends on the options and its index only, and all
/// functions may be called from several threads.
class Simulator {
 public:
  /// Throws DatasetError if the trajectory file cannot be used.
  explicit Simulator(const Options& options);

  /// The static part of the scene, before it changes.
  const World& world() const { return world_; }
  /// The bodies that move, or move with the camera.
  const Bodies& bodies() const { return bodies_; }
  const RigCalibration& rig() const { return rig_; }
  int size() const { return static_cast<int>(t_ns_.size()); }
  /// Frames after which the world's own walk repeats; 0 for a trajectory from a file.
  int frames_per_lap() const { return frames_per_lap_; }
  int64_t t_ns(int index) const { return t_ns_[index]; }
  const std::vector<ImuSample>& imu_samples() const { return imu_samples_; }
  SE3 T_w_c(int index) const { return motion_->At(index); }

  /// The pair as the cameras record it; left and right are rendered in two threads.
  StereoImages Render(int index) const;
  /// The gain of the slow changes of exposure, 1 in the mean.
  double Gain(int index) const;
  /// The left camera's view without distortion, for tests.
  View LeftView(int index) const;
  /// True depth (z, metres) of the left view at the pixel centres, 0 for the sky.
  std::vector<float> RenderDepth(int index) const { return RenderDepthMap(SceneAt(index), LeftView(index)); }
  /// Body of the left view at the pixel centres, -1 if none.
  std::vector<int> RenderBodies(int index) const;

 private:
  /// One camera of the rig: its pose in the left camera, and its lens.
  struct Eye {
    Eigen::Matrix3d R_l_cam = Eigen::Matrix3d::Identity();
    Eigen::Vector3d t_l_cam = Eigen::Vector3d::Zero();
    Lens lens;
  };

  void MakeMotion();
  void MakeEyes();
  void MakeBodies();
  void MakeInertialSensor();
  Scene SceneAt(double frame) const { return {WorldAt(frame), bodies_.At(frame).quads}; }
  const World& WorldAt(double frame) const;
  CameraCalibration Calibration(const Eye& eye) const;
  View ViewOf(const Eye& eye, const SE3& T_w_c) const;
  /// `frame` is a time in frames and may be fractional.
  int BlurSteps(const Eye& eye, double frame) const;
  std::vector<float> RadianceAt(const Eye& eye, double frame) const;
  std::vector<float> Radiance(const Eye& eye, double frame) const;
  cv::Mat RenderEye(const Eye& eye, int index, int camera) const;

  Options options_;
  int frames_per_lap_ = 0;
  std::unique_ptr<Motion> motion_;
  std::vector<int64_t> t_ns_;
  World world_;
  World changed_world_;  ///< after `Options::changed_after` laps
  Bodies bodies_;
  Eye left_;
  Eye right_;
  RigCalibration rig_;
  std::vector<ImuSample> imu_samples_;
  Weather weather_;
  Sensor sensor_;
};

}  // namespace plslam::synthetic

namespace plslam {

/// Opens a built-in world from "synthetic:NAME?option=value&..." (the text after "synthetic:" is `description`). Throws
/// DatasetError with the known names or options for an unknown one.
std::unique_ptr<Dataset> OpenSyntheticDataset(const std::string& description);

}  // namespace plslam
