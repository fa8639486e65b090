// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/datasets/yaml_map.h"
#include "core/files/notes.h"
#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// Adds the masked parts of a camera's images (the bonnet of a car, an arm of the robot, a lens hood) to the mask of
/// `camera`, whose size is known; all in pixels of the image as recorded. `mask` is an image of the same size, in the
/// folder of the file or below: 0 (black) is masked out, all other values are used. `mask_polygons` and `borders_px`
/// [left, top, right, bottom] are masked out. Throws DatasetError that names file, line, key, value and bound.
void ReadMask(const YamlMap& yaml, CameraCalibration* camera);

/// Adds the parts that the image at `path` masks out. Throws DatasetError that names it.
void AddMaskImage(const std::string& path, CameraCalibration* camera);

/// Read the key `resolution_px` of a camera, and `rate_hz` of a rig; a default if they are absent. Throw DatasetError
/// that names file, line, key, value and bound.
ImageSize ReadResolution(const YamlMap& yaml, const ImageSize& image_size);
double ReadRate_hz(const YamlMap& yaml, double fallback);

/// Reads plslam's own camera file (docs/datasets.md has the keys), `camera.yaml` of a folder of images or of a TUM
/// RGB-D sequence. A camera without `resolution_px` gets that of the other one, else `image_size`. The file may also be
/// one of another program's (calibrations/foreign_calibration.h), or name such files by `from`, a file or a list of
/// files beside it, with the `unit` of their lengths. `notes`, if given, receives warnings and remarks. Throws
/// DatasetError.
RigCalibration ReadCameraFile(const std::string& path, const ImageSize& image_size, Notes* notes = nullptr);

/// Returns the files that a camera file names by `from`, and the metres of its `unit`. Throw DatasetError.
std::vector<std::string> FilesNamedBy(const YamlMap& yaml);
std::optional<double> UnitNamedBy(const YamlMap& yaml);

/// Returns whether `path` is a camera file whose `source` names the source of live images; readers of datasets ignore
/// that key. False also if it cannot be read.
bool NamesSource(const std::string& path);

/// Finds the calibration of a folder: its camera.yaml, or else the file (or pair of files) of another program in it;
/// empty if there is none. Throws DatasetError if there are several candidates.
std::vector<std::string> CalibrationOf(const std::string& folder);

/// Reads the files that `CalibrationOf` found.
RigCalibration ReadCalibration(const std::vector<std::string>& paths, const ImageSize& image_size,
                               Notes* notes = nullptr);

/// Returns the text of a camera.yaml of a rig, every number to its last digit. Masks are left out.
std::string CameraFileText(const RigCalibration& rig);

/// An RGB-D rig from its camera: the right one is a copy of it, moved by the virtual baseline along its x axis.
RigCalibration MakeRgbdRig(const CameraCalibration& camera, double baseline_m, double depth_units_per_m);

/// Baseline of the virtual right camera of RGB-D rigs. It equals the baseline of the Kinect's projector and camera: a
/// constant error of the virtual disparity d = b f / Z then behaves like the sensor's own error, which grows with Z^2.
inline constexpr double kVirtualBaseline_m = 0.075;

}  // namespace plslam
