// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/calibration.h"
#include "core/io/images/image_file.h"

namespace plslam {

/// The calibration of a stereo rig as another program wrote it.
struct ForeignCalibration {
  RigCalibration rig;
  /// "Kalibr camchain", say.
  std::string format;
  /// What was made of its transforms, in one sentence: which direction they have in the file.
  std::string direction;
  /// Notes for the user, in whole sentences: which cameras of several are taken, for example.
  std::vector<std::string> notes;
  /// Lengths of the format have a unit of their own and are converted: no other may be given.
  bool has_own_unit = false;
};

/// The format of a file, found by looking at it; empty where it is none of those that can be read (docs/datasets.md).
/// Throws nothing.
std::string ForeignFormat(const std::string& path);

/// Returns why a file is no calibration of a stereo rig, and what to give instead, as a sentence that begins with the
/// path: settings of one camera, XML, formats that are not read, invalid YAML. Empty for files of other subjects.
/// Throws nothing.
std::string WhyNoCalibration(const std::string& path);

/// Metres of a unit of length by its name: m, cm, mm; nullopt for others.
std::optional<double> MetresOf(std::string_view unit);

/// Reads the one or two files of a rig. `image_size` chooses among the resolutions of ZED files, and fills in where a
/// file does not tell the size (0 x 0: not known). Lengths are in metres, or in `metres_per_unit`. The left camera is
/// the body unless the file knows an IMU. Throws DatasetError that names file, line, key, value and what to do.
ForeignCalibration ReadForeignCalibration(const std::vector<std::string>& paths, const ImageSize& image_size,
                                          std::optional<double> metres_per_unit = std::nullopt);

/// Returns WhyNoCalibration of the first file in `folder` that has such a reason; empty where none has.
std::string UnreadCalibration(const std::string& folder);

/// The files right in `folder` that have a foreign format, in the order of their names. Throws DatasetError where
/// they are of several formats, so that none can be chosen.
std::vector<std::string> FindForeignCalibration(const std::string& folder);

}  // namespace plslam
