#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "vo_process/stereo/image_levels.h"
#include "vo_process/stereo/patch.h"

namespace plslam {

/// The pixels around a point of an image, kept so that the point can be found again: small, and quick to take.
struct PatchPixels {
  /// Of an 11x11 patch and one pixel around it, by rows.
  static constexpr int kRim = kSide + 2;

  /// Size of a pixel of the patch in pixels of the image, and where the point lies from the middle one, in pixels of the
  /// patch.
  double size_px = 1.0;
  Eigen::Vector2d off_center = Eigen::Vector2d::Zero();
  std::array<uint8_t, kRim * kRim> pixels{};
};

/// The same ready to be looked for.
struct ReferencePatch {
  double size_px = 1.0;
  Eigen::Vector2d off_center = Eigen::Vector2d::Zero();
  /// Without their means; the derivatives also orthogonal to the pixels.
  Patch pixels;
  Patch derivative_u;
  Patch derivative_v;
  /// Squared norm of `pixels`; products of the derivatives.
  double energy = 0.0;
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
  /// By how many pixels of the patch the place errs where the shape of the patch now is wrong by 1 (a relative stretch
  /// of 1, say) in a random way.
  double shape_sensitivity = 0.0;
};

/// Where a patch was found again.
struct TrackedPatch {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double sigma_px = 0.0;
  /// Normalised correlation, and contrast now relative to then.
  double correlation = 0.0;
  double gain = 0.0;
};

/// What is expected of a patch before it is looked for.
struct PatchExpectation {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  /// Derivative of places now by places then, and the deviation of its entries.
  Eigen::Matrix2d now_from_then = Eigen::Matrix2d::Identity();
  double shape_sigma = 0.0;
};

/// What is around `px`, where a feature was found at a pixel size of `scale`. nullopt where that leaves the image.
std::optional<PatchPixels> TakePatch(const ImageLevels& image, const Eigen::Vector2d& px, double scale);

/// nullopt where it is no corner: along an edge there is nothing to hold on to.
std::optional<ReferencePatch> MakeReferencePatch(const PatchPixels& pixels);

/// Finds a patch again by Gauss-Newton on its place (inverse compositional: the normal equations are those of the
/// reference), its shape as expected, for any gain and offset of brightness.
///
/// The deviation is made of the residuals, of what the unknown part of the shape does to this patch, and of
/// what no residual shows. nullopt where the patch leaves the image, does not converge, ends more than two pixels of its
/// size from where it was expected, or is so noisy that an edge passes for a corner.
std::optional<TrackedPatch> TrackPatch(const ReferencePatch& reference, const ImageLevels& image,
                                       const PatchExpectation& expected);

}  // namespace plslam
