// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/features/features.h"
#include "vo_process/tracking/frame_aligner.h"

namespace plslam::vo {

/// How much surer points claim to be than they are, by what lines say.
///
/// Corners that slide along edges, as where a bar crosses a stripe behind it, leave small residuals, since the pose
/// follows them; those of the lines tell. So the residuals of the two kinds are compared, each in its own sigmas
/// (variance components, after Helmert), and sigmas of points grow with the ratio of the two. Lines are never
/// told to count less: on real images their residuals are large for reasons that cancel between lines.
class NoiseScale {
 public:
  /// `max_scale`: as large as the factor may get; 1 leaves everything as it is.
  explicit NoiseScale(double max_scale) : max_scale_(max_scale) {}

  /// Factor of the sigmas of points, 1 to `max_scale`.
  double scale() const { return scale_; }

  /// Multiplies the sigmas of all points, of place and disparity.
  void Apply(StereoFeatures& features) const;

  /// Learns from a frame that was found; where points or lines are too few to tell, what was learned fades.
  void Observe(const Alignment& alignment);

  /// All that it goes on with, for `core/io/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.scale_);
  }

 private:
  double max_scale_;
  double scale_ = 1.0;
};

/// Adds to the sigmas of lines what their fit cannot know: edges that are not straight, that lie on round
/// objects, or that two detections cut from neighbouring edges. `sigma_px` is across the segment, in either image.
void AddLineModelError(double sigma_px, StereoFeatures& features);

}  // namespace plslam::vo
