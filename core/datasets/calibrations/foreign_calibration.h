// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/datasets/imu_parts.h"
#include "core/files/notes.h"
#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// The calibration of a stereo rig as another program wrote it.
struct ForeignCalibration {
  /// With the inertial sensor that the file describes, if any.
  RigCalibration rig;
  /// For example "Kalibr camchain".
  std::string format;
  /// The assumed direction of the file's transforms, in one sentence.
  std::string direction;
  /// For example which of several cameras are used.
  Notes notes;
  /// The format defines its own unit of length, which is converted: the user may not give another.
  bool has_own_unit = false;
};

/// Returns the format of a file, recognised by its content; empty if it is none of the supported ones
/// (docs/datasets.md). Throws nothing.
std::string ForeignFormat(const std::string& path);

/// Returns the reason why a file is no calibration of a stereo rig, and the remedy, as a sentence that begins with the
/// path: settings of one camera, XML, unsupported formats, invalid YAML. Empty for files of other subjects. Throws
/// nothing.
std::string WhyNoCalibration(const std::string& path);

/// Returns the metres of a unit of length by its name: m, cm, mm; nullopt for others.
std::optional<double> MetresOf(std::string_view unit);

/// Reads the one or two files of a rig. `image_size` selects one of the resolutions of ZED files, and is used if a file
/// has no size (0 x 0: unknown). Lengths are in metres, or in `metres_per_unit`. The left camera is the body unless the
/// file has an IMU. Throws DatasetError that names file, line, key, value and remedy.
ForeignCalibration ReadForeignCalibration(const std::vector<std::string>& paths, const ImageSize& image_size,
                                          std::optional<double> metres_per_unit = std::nullopt);

/// Reads what such files, or files beside them that belong to them, state about an inertial sensor; nothing for formats
/// without one. `notes` receives what is not used. Throws DatasetError.
ImuParts ReadForeignImu(const std::vector<std::string>& paths, std::optional<double> metres_per_unit, Notes* notes);

/// Returns WhyNoCalibration of the first file in `folder` that has such a reason; empty if none has.
std::string UnreadCalibration(const std::string& folder);

/// Returns the files directly in `folder` that have a foreign format, in the order of their names. Throws DatasetError
/// if they have several formats, so that none can be chosen.
std::vector<std::string> FindForeignCalibration(const std::string& folder);

}  // namespace plslam
