// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "tests/support/changed_images.h"

namespace plslam::test {

/// What a worse camera, worse light, or somebody in front of it does to a pair.
struct Worsening {
  /// Grey values; left and right have noise of their own.
  double noise_sigma = 0.0;
  /// Factor of the grey values, frame after frame from one to the other and back; the right image half as much.
  double darkest = 1.0;
  int exposure_period = 20;
  /// Of the blur, in pixels.
  double blur_sigma_px = 0.0;
  /// Side of a black square in the middle of both images, as a share of their height; it covers what is behind it.
  double covered = 0.0;
  /// Of snow, bright, in each image; other ones in every image.
  int streaks = 0;
};

/// A dataset with its images made worse. Noise is seeded by the number of pairs read before: the same at every run,
/// another where a pair is read again.
class WorseImages : public ChangedImages {
 public:
  WorseImages(const Dataset& dataset, const Worsening& worsening) : ChangedImages(dataset), worsening_(worsening) {}

  StereoImages Read(int index) const override;

 private:
  Worsening worsening_;
  mutable uint64_t n_read_ = 0;
};

}  // namespace plslam::test
