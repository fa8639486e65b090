// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"

namespace plslam {

/// A match whose patches tell its row without knowing it (corners, not edges): what is learned from of how rows
/// differ.
struct RowObservation {
  /// Which of the points.
  size_t point = 0;
  /// As `RowField` tells places.
  Eigen::Vector2d place_px = Eigen::Vector2d::Zero();
  double offset_px = 0.0;
  double variance_px2 = 1.0;
  /// With so many others in its part of the image, which err alike.
  double sharing = 1.0;
};

/// Those of the points of a pair.
std::vector<RowObservation> RowObservationsOf(const StereoFeatures& features, const StereoCamera& camera);

/// How far an innovation may be off, in standard deviations, to be learned from.
inline constexpr double kMaxRowDeviation = 4.0;

/// Factor of the variance of an innovation of so many standard deviations (Huber).
double RowHuberFactor(double deviation);

}  // namespace plslam
