// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/yaml_map.h"
#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// Adds what a camera's keys leave out of its images (the bonnet of a car, an arm of the robot, a lens hood) to the
/// mask of `camera`, whose size is known; all in pixels of the image as recorded. `mask` is an image of the same
/// size, beside the file or below: 0 (black) is left out, all else in use. `mask_polygons` and `borders_px` [left,
/// top, right, bottom] are left out. Throws DatasetError that names file, line, key, value and bound.
void ReadMask(const YamlMap& yaml, CameraCalibration* camera);

/// Adds what the image at `path` leaves out. Throws DatasetError that names it.
void AddMaskImage(const std::string& path, CameraCalibration* camera);

/// The key `resolution_px` of a camera, `rate_hz` of a rig; another value where they are absent. Throw DatasetError that
/// names file, line, key, value and bound.
ImageSize ReadResolution(const YamlMap& yaml, const ImageSize& image_size);
double ReadRate_hz(const YamlMap& yaml, double fallback);

/// Our own camera file (docs/datasets.md has the keys), `camera.yaml` of a folder of images or of a TUM RGB-D
/// sequence. Cameras that name no `resolution` get `image_size`. The file may as well be one of another program's
/// (calibrations/foreign_calibration.h), or name such ones by `from`, a file or a list of files beside it, with the
/// `unit` of their lengths. `notes`, where it is given, gets what the user should know, in whole sentences. Throws
/// DatasetError.
RigCalibration ReadCameraFile(const std::string& path, const ImageSize& image_size,
                              std::vector<std::string>* notes = nullptr);

/// `path` is a file of our own that says by `source` where live images come from: a camera file like any other
/// elsewhere. False, too, where it cannot be read.
bool NamesSource(const std::string& path);

/// The calibration of a folder: its camera.yaml, or else the file (or pair of files) of another program that lies in
/// it; empty where there is none. Throws DatasetError where it cannot be told which one is meant.
std::vector<std::string> CalibrationOf(const std::string& folder);

/// Reads what `CalibrationOf` found.
RigCalibration ReadCalibration(const std::vector<std::string>& paths, const ImageSize& image_size,
                               std::vector<std::string>* notes = nullptr);

/// The text of a camera.yaml of a rig, every number to its last digit. Masks are left out.
std::string CameraFileText(const RigCalibration& rig);

/// An RGB-D rig from its camera: the right one is a copy of it, moved by the virtual baseline along its x axis.
RigCalibration MakeRgbdRig(const CameraCalibration& camera, double baseline_m, double depth_units_per_m);

/// Baseline of the virtual right camera of RGB-D rigs. That of the Kinect's own projector and camera: then a constant
/// error of the virtual disparity d = b f / Z has the course of the sensor's own error, which grows with Z^2.
inline constexpr double kVirtualBaseline_m = 0.075;

}  // namespace plslam
