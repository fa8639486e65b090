#pragma once

#include <string>

#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// Our own camera file (docs/datasets.md has the keys), `camera.yaml` of a folder of images or of a TUM RGB-D
/// sequence. Cameras that name no `resolution` get `image_size`. Throws DatasetError.
RigCalibration ReadCameraFile(const std::string& path, const ImageSize& image_size);

/// An RGB-D rig from its camera: the right one is a copy of it, moved by the virtual baseline along its x axis.
RigCalibration MakeRgbdRig(const CameraCalibration& camera, double baseline_m, double depth_units_per_m);

/// Baseline of the virtual right camera of RGB-D rigs. That of the Kinect's own projector and camera: then a constant
/// error of the virtual disparity d = b f / Z has the course of the sensor's own error, which grows with Z^2.
inline constexpr double kVirtualBaseline_m = 0.075;

}  // namespace plslam
