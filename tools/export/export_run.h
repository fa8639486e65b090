// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace plslam::exports {

/// A format that runs and maps can be exported to.
struct ExportFormat {
  std::string name;
  std::string what;
  bool needs_map = true;
  /// Needs the features of keyframes, which only a saved map has.
  bool needs_features = false;
  /// Needs the surfaces beside a saved map.
  bool needs_surfaces = false;
};

/// Returns all formats, in the order in which they are written.
const std::vector<ExportFormat>& ExportFormats();

struct ExportRequest {
  /// Map file or folder of a run (`ReadRun`), or LCM log of a run, of which the files of viewer_headless are then
  /// written to the folder `run` in `out`.
  std::string source;
  /// Folder to write to; it is made.
  std::string out;
  /// Names of formats; empty: all for which the source has the content.
  std::vector<std::string> formats;
  /// Source of the images; empty: the log, if the source is one with frames; otherwise no images are written, and poses
  /// are those of the rectified camera.
  std::string dataset;
};

struct ExportedFile {
  std::string path;
  std::string what;
};

/// Writes the files of docs/exports.md. Throws std::runtime_error if the source does not have the content that a named
/// format needs.
std::vector<ExportedFile> ExportRun(const ExportRequest& request);

}  // namespace plslam::exports
