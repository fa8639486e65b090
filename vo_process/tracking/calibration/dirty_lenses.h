// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/features/feature_extractor.h"
#include "core/features/features.h"
#include "core/geometry/stereo_camera.h"
#include "vo_process/tracking/calibration/lens_dirt.h"

namespace plslam::vo {

/// Dirt on the two lenses. Corners of the left image have a partner in the right one, or not; those of the right image
/// are the partners, and what a detector finds elsewhere.
class DirtyLenses {
 public:
  explicit DirtyLenses(const StereoCamera& camera) : left_(camera), right_(camera) {}

  const LensDirt& left() const { return left_; }
  const LensDirt& right() const { return right_; }
  bool HasDirt() const { return left_.HasDirt() || right_.HasDirt(); }
  PairDirt Cells() const { return {left_.Cells(), right_.Cells()}; }

  /// Learns from the next pair. `right_corners` are corners of the right image, in rectified pixels; none without a
  /// right image. Corners whose partner a mask hides are left out: their part of the scene may move in another way than
  /// the one that both images show.
  void Observe(const StereoFeatures& features, const std::vector<Eigen::Vector2d>& right_corners,
               const FeatureMask& left_mask, const FeatureMask& right_mask);

  /// Removes points on the left lens's dirt, and segments with both ends there; and depths from partners on the right
  /// lens's dirt.
  void RemoveFrom(StereoFeatures& detected) { n_removed_ = Remove(detected); }
  /// The same of features that were followed.
  void RemoveFromFollowed(StereoFeatures& followed) const { Remove(followed); }

  /// Number of points removed from the last pair with detection: so many more have to be detected.
  int n_removed() const { return n_removed_; }

  /// The state between frames, for `core/files/archive.h`.
  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.left_, self.right_, self.n_removed_);
  }

 private:
  int Remove(StereoFeatures& features) const;

  LensDirt left_;
  LensDirt right_;
  int n_removed_ = 0;
};

}  // namespace plslam::vo
