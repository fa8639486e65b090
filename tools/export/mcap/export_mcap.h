// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "core/datasets/dataset.h"
#include "core/run/run.h"

namespace plslam::exports {

/// Content of a written MCAP file.
struct McapContent {
  int64_t frames = 0;
  int64_t images = 0;
  bool has_map = false;
  bool has_grid = false;
  bool has_surfaces = false;
};

/// Writes a run and its map as messages of ROS 2 (docs/exports.md has the table of topics). Images, as recorded, are
/// read from `dataset`, unless it is null. Throws std::runtime_error if files of the run are damaged or the file cannot
/// be written.
McapContent ExportMcap(const Run& run, const Dataset* dataset, const std::string& path);

/// Returns a layout for Foxglove and Lichtblick that shows these topics.
std::string FoxgloveLayout();

}  // namespace plslam::exports
