// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "vo_process/tracking/motion/frame_aligner.h"

namespace plslam::vo {

/// Factor by which the sigmas of points are too small, estimated with the help of lines.
///
/// Corners that slide along edges, as where a bar crosses a stripe behind it, leave small residuals, because the pose
/// follows them; but the residuals of lines grow. The residuals of the two feature types are compared, each in units of
/// its sigmas (variance components, after Helmert), and the sigmas of points grow with the ratio. Sigmas of lines
/// never grow: on real images their residuals are large for reasons that cancel between lines.
class NoiseScale {
 public:
  /// `max_scale`: largest factor; 1 disables it.
  explicit NoiseScale(double max_scale) : max_scale_(max_scale) {}

  /// Factor of the sigmas of points, 1 to `max_scale`.
  double scale() const { return scale_; }

  /// Multiplies the sigmas of position and disparity of all points.
  void Apply(StereoFeatures& features) const;

  /// Updates the factor from a tracked frame; with too few points or lines it fades to 1.
  void Observe(const Alignment& alignment);

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.scale_);
  }

 private:
  double max_scale_;
  double scale_ = 1.0;
};

/// Adds the model error of lines to their sigmas: edges that are not straight, that lie on round objects, or that two
/// detections cut from neighbouring edges. `sigma_px` is across the segment, in either image.
void AddLineModelError(double sigma_px, StereoFeatures& features);

}  // namespace plslam::vo
