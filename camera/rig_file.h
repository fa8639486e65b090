// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/yaml_map.h"
#include "core/geometry/calibration.h"

namespace plslam::camera {

/// Where the images of two cameras come from.
struct SourceSpec {
  /// What is behind it, by the key of the file.
  enum class Type { kSideBySide, kPair, kGige, kFiles, kRtsp, kPipeline };

  Type type = Type::kPair;
  /// One (an image with both side by side, or a pipeline) or two, left and right: devices, names of GigE cameras, files or
  /// URLs.
  std::vector<std::string> inputs;
  /// Left and right images that are taken further apart are no pair.
  double max_skew_ms = 5.0;
  /// Cameras that give no frames for longer end the process.
  double give_up_s = 10.0;
};

/// "side_by_side", "pair", ...: the key of the file.
std::string KeyOf(SourceSpec::Type type);

/// The end of its stream is the end of the run: not so of a camera that is unplugged.
bool MayEnd(SourceSpec::Type type);

/// The map `source` of a rig file, names of `files` as they stand there. Throws DatasetError as `ReadRigFile`.
SourceSpec ReadSource(const YamlMap& yaml);

/// A rig file: the keys of camera.yaml, and a map `source`.
struct LiveRig {
  std::string path;
  RigCalibration rig;
  SourceSpec source;
  /// Notes about the calibration for the user, in whole sentences.
  std::vector<std::string> notes{};
};

/// Relative names of `files` are meant beside the rig file. Throws DatasetError that names file, line, key and value.
LiveRig ReadRigFile(const std::string& path);

}  // namespace plslam::camera
