// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "core/datasets/dataset.h"

namespace plslam::rectify_check {

/// Effect of an offset of the disparities on lengths, which no row shows: a yaw between the cameras, principal points.
struct LengthError {
  /// Change of lengths without correction, and its sigma; nullopt where no offset is proved.
  std::optional<double> percent;
  double sigma_percent = 0.0;
  /// Frames that were tracked, and frames that were read.
  int tracked = 0;
  int frames = 0;
};

/// Returns the finding in a sentence: that of the run's warning `disparities_off` where its condition holds.
std::string Sentence(const LengthError& error);

/// Tracks the first frames of a dataset as vo_process does by default (without map and inertial sensor), and returns
/// the estimate of its self-calibration, which the run's warning `disparities_off` gives, too. Throws as the dataset
/// and `vo::StereoFrontEnd`.
LengthError MeasureLengthError(const Dataset& dataset, const RigCalibration& rig);

}  // namespace plslam::rectify_check
