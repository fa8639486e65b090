// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "core/datasets/yaml_map.h"
#include "core/files/notes.h"
#include "core/geometry/calibration.h"

namespace plslam::camera {

/// The source of the images of two cameras.
struct SourceSpec {
  /// Type of the source, named by its key in the file.
  enum class Type { kSideBySide, kPair, kGige, kFiles, kRtsp, kPipeline };

  Type type = Type::kPair;
  /// One (an image with both side by side, or a pipeline) or two, left and right: devices, names of GigE cameras, files
  /// or URLs.
  std::vector<std::string> inputs;
  /// Left and right images with a larger time difference are not a pair.
  double max_skew_ms = 5.0;
  /// Cameras that give no frames for longer end the process.
  double give_up_s = 10.0;
};

/// "side_by_side", "pair", ...: the key of the file.
std::string KeyOf(SourceSpec::Type type);

/// The end of its stream is the end of the run: not so of a camera that is unplugged.
bool MayEnd(SourceSpec::Type type);

/// Reads the map `source` of a rig file; names of `files` are returned unchanged. Throws DatasetError as `ReadRigFile`.
SourceSpec ReadSource(const YamlMap& yaml);

/// A rig file: the keys of camera.yaml, and a map `source`.
struct LiveRig {
  std::string path;
  RigCalibration rig;
  SourceSpec source;
  Notes notes{};  ///< about the calibration
};

/// Reads a rig file; relative names of `files` refer to its folder. Throws DatasetError that names file, line, key and
/// value.
LiveRig ReadRigFile(const std::string& path);

/// Reads a rig file whose cameras may have no calibration yet: their lenses are then made up from `resolution_px`. It
/// suffices for `PipelineText`. Throws as `ReadRigFile`.
LiveRig ReadRigFileForPipeline(const std::string& path);

/// Returns a camera of the size `resolution_px` with a made-up lens. Throws DatasetError if the size is missing or
/// invalid.
CameraCalibration ReadUncalibratedCamera(const YamlMap& yaml);

}  // namespace plslam::camera
