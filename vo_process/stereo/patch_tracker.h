// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace plslam::vo {

/// Grey levels around a point, in the `HalvedImages` of the image in which it was first seen: 17x17 pixels of the level
/// whose pixels are nearest in size to those of its octave, and of the coarser ones.
struct StoredPatch {
  static constexpr int kReach = 8;
  static constexpr int kWidth = 2 * kReach + 1;
  static constexpr size_t kLevels = 3;
  using Pixels = std::array<uint8_t, static_cast<size_t>(kWidth) * kWidth>;

  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  int32_t finest = 0;  ///< level of the first image
  int32_t n_levels = 0;
  std::array<Pixels, kLevels> images{};

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.px, self.finest, self.n_levels);
    for (auto& image : self.images) a(image);
  }
};

/// Returns the patch around `px`, detected at a pixel size of `scale`; nullopt at the border of the image, and if it is no
/// corner: along an edge, its position would follow errors of the expected derivative.
std::optional<StoredPatch> StorePatch(const std::vector<cv::Mat>& levels, const Eigen::Vector2d& px, double scale);

/// Order in which images are searched: the finest first, and coarser ones if the patch is not within 2.5 of its pixels
/// there, or coarser ones first.
enum class SearchRange { kNear, kWide };

/// Expected position of a patch, and derivative of its pixels in the present image by those in the first one.
struct PatchExpectation {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d now_from_then = Eigen::Matrix2d::Identity();
};

struct TrackedPatch {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  /// Normalised correlation of the patches, and contrast of the present relative to the first one.
  double correlation = 0.0;
  double gain = 0.0;
};

/// Finds an 11x11 patch in the `HalvedImages` of the present image, for any gain and offset of brightness (exposures may
/// differ).
///
/// Gauss-Newton on the position (inverse compositional, Baker and Matthews 2004): the stored patch, warped by the
/// expected derivative, is the template, so the normal equations are built once. In each image the patch moves by at most
/// 2.5 of its pixels.
///
/// Returns nullopt if the patch leaves an image, is no corner in it, or does not converge.
std::optional<TrackedPatch> TrackPatch(const StoredPatch& patch, const std::vector<cv::Mat>& now,
                                       const PatchExpectation& expected, SearchRange range);

}  // namespace plslam::vo
