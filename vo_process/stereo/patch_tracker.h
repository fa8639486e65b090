// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace plslam::vo {

/// Grey levels around a point, in the `HalvedImages` of the image in which it was first seen: of the level whose pixels are
/// nearest in size to those of its octave, enough for a patch that is stretched by half, and of up to two coarser ones.
struct StoredPatch {
  static constexpr int kFinestReach = 10;
  static constexpr int kCoarseReach = 7;
  static constexpr int kLevels = 3;
  template <int Reach>
  using Square = std::array<uint8_t, static_cast<size_t>(2 * Reach + 1) * (2 * Reach + 1)>;

  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  int32_t finest_level = 0;  ///< of the first image
  int32_t n_levels = 0;
  Square<kFinestReach> finest{};
  std::array<Square<kCoarseReach>, kLevels - 1> coarse{};

  template <class Archive, class Self>
  static void Fields(Archive& a, Self& self) {
    a(self.px, self.finest_level, self.n_levels, self.finest);
    for (auto& square : self.coarse) a(square);
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

/// A patch and where it is expected.
struct ExpectedPatch {
  const StoredPatch* patch = nullptr;
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
};

/// Returns how far from their expected positions the patches are together, in pixels: the shift with the best mean
/// correlation of their coarsest pixels, among all of up to `kMostShift` of these. The image moves like that when the camera
/// turns (Klein and Murray 2008). Returns nullopt if the patches do not agree.
std::optional<Eigen::Vector2d> CommonShift(std::span<const ExpectedPatch> patches, const std::vector<cv::Mat>& now);

inline constexpr int kMostShift = 8;

}  // namespace plslam::vo
