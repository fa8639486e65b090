// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/support/changed_images.h"

namespace plslam::test {

/// Degradation of a pair by a worse camera, worse light, or an obstacle in front of it.
struct Worsening {
  /// Grey values; the noise of left and right is independent.
  double noise_sigma = 0.0;
  /// Factor of the grey values, frame after frame from one to the other and back; the right image half as much.
  double darkest = 1.0;
  int exposure_period = 20;
  /// Sigma of the blur in pixels.
  double blur_sigma_px = 0.0;
  /// Side of a black square in the middle of both images, as a share of their height; it hides the scene behind it.
  double covered = 0.0;
  /// Number of bright snow streaks in each image; different ones in every image.
  int streaks = 0;
  /// Number of spots of dirt on each lens, as in the synthetic worlds; for sizes and places `dirt_seed`.
  int dirt = 0;
  int dirt_seed = 1;
  /// Frames from the first one that are black, `black_count` in a row, and again after every `black_every` frames.
  int black_first = 0;
  int black_count = 0;
  int black_every = 1 << 30;

  bool IsBlack(int index) const { return index >= black_first && (index - black_first) % black_every < black_count; }
};

/// A dataset with degraded images. Noise is seeded by the number of pairs read before: the same in every run, but
/// different when a pair is read again.
class WorseImages : public ChangedImages {
 public:
  WorseImages(const Dataset& dataset, const Worsening& worsening) : ChangedImages(dataset), worsening_(worsening) {}

  StereoImages Read(int index) const override;

 private:
  Worsening worsening_;
  mutable uint64_t n_read_ = 0;
};

}  // namespace plslam::test
