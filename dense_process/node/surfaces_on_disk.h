// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "core/map/map.h"
#include "dense_process/dense_map.h"
#include "dense_process/options.h"

namespace plslam::dense {

/// The state of dense_process for a restart, if it has a state file, the surfaces beside a saved map, and why files are
/// not written. If the state cannot be written, this is logged once and the process continues, with a higher cost of a
/// crash. Failures of results and saved surfaces are kept: they are the error with which the process exits.
class SurfacesOnDisk {
 public:
  /// Makes the folder of the results. Throws std::filesystem::filesystem_error.
  explicit SurfacesOnDisk(const DenseOptions& options);

  /// Returns the file of surfaces to continue: the state of a previous process, or the surfaces of the saved map.
  /// Empty: none.
  std::string Earlier() const;

  /// A keyframe was fused. Writes the state if enough have been since the last one.
  void Fused(const DenseMap& surfaces, const Map& map);
  /// Writes the state, if there is a file for it and a keyframe was fused since the last one.
  void KeepState(const DenseMap& surfaces, const Map& map);
  /// Writes the surfaces beside a saved map; nullptr: it has none, and those of an earlier map there are removed. Returns
  /// why that failed; empty: it did not.
  std::string SaveBeside(const std::string& map_file, const DenseMap* surfaces, const Map& map);

  /// Sets why the results of the run are not written; empty: they are.
  void SetFailure(const std::string& why) { failure_ = why; }
  const std::string& failure() const { return failure_; }
  /// Returns the failures of the results and of saved surfaces; empty: none.
  std::string Failures() const;

 private:
  std::string state_file_;
  std::string map_file_;
  size_t n_since_state_ = 0;  ///< keyframes
  bool state_failed_ = false;
  std::string failure_;
  std::string save_failure_;
};

}  // namespace plslam::dense
