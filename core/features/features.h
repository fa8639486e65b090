// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/geometry/stereo_camera.h"
#include "core/geometry/triangulation.h"

namespace plslam {

/// 256 bits: ORB for points, LBD for lines.
using Descriptor = std::array<uint64_t, 4>;

/// Number of differing bits, 0..256.
int HammingDistance(const Descriptor& a, const Descriptor& b);

/// A point of one rectified image.
struct PointFeature {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  float response = 0.0F;
  float angle_rad = 0.0F;
  int octave = 0;
  Descriptor descriptor{};
  /// Size of a pixel of the octave, in pixels of the image, to which `px` is accurate.
  double scale = 1.0;
};

/// A line segment of one rectified image.
struct LineFeature {
  Segment2 segment;
  float response = 0.0F;
  int octave = 0;
  Descriptor descriptor{};
};

/// Points and lines of one rectified image.
struct ImageFeatures {
  std::vector<PointFeature> points;
  std::vector<LineFeature> lines;
};

/// A point of the left image with the disparity of its match, if it has one.
struct StereoPoint {
  PointFeature left;
  /// u_left - u_right with sub-pixel precision; negative without a match.
  double disparity_px = -1.0;
  /// Standard deviations of u and v, and of the disparity.
  double sigma_px = 1.0;
  double sigma_disparity_px = 1.0;
  /// Change of the disparity per pixel to the right and downwards, if the surface around the point shows it.
  Eigen::Vector2d disparity_slope = Eigen::Vector2d::Zero();
  /// Row of the match minus row of the left point, measured in the images, and its standard deviation; negative if it
  /// was not measured.
  double row_offset_px = 0.0;
  double sigma_row_px = -1.0;
  /// Whether the row has several equally good matches, so that there is no depth.
  bool is_ambiguous = false;
  /// Whether the right image shows the point at about the same pixel, too far away for a depth.
  bool is_far = false;

  bool HasDepth() const { return disparity_px > 0.0; }
};

/// A line segment of the left image with the disparities of its endpoints, if known.
struct StereoLine {
  LineFeature left;
  /// Disparities of the left endpoints, measured on the matched right line. Negative without depth: no match, or nearly
  /// parallel to the baseline.
  double disparity_p_px = -1.0;
  double disparity_q_px = -1.0;
  /// Standard deviation of an endpoint across the segment, and of the two disparities.
  double sigma_px = 1.0;
  double sigma_disparity_p_px = 1.0;
  double sigma_disparity_q_px = 1.0;

  bool HasDepth() const { return disparity_p_px > 0.0 && disparity_q_px > 0.0; }
  /// Disparity of the midpoint; negative without depth.
  double MiddleDisparity_px() const { return HasDepth() ? 0.5 * (disparity_p_px + disparity_q_px) : -1.0; }
};

/// Features of one stereo frame. Points and lines without depth are kept, since later frames may determine it.
struct StereoFeatures {
  std::vector<StereoPoint> points;
  std::vector<StereoLine> lines;
  /// The image in which they were detected; nullopt: that of the camera in which they are expressed (see `FeaturesInCamera`).
  std::optional<TakenImage> image;
};

/// A view of features stored elsewhere.
struct FeaturesView {
  std::span<const StereoPoint> points;
  std::span<const StereoLine> lines;
  std::optional<TakenImage> image;

  FeaturesView() = default;
  // NOLINTNEXTLINE(google-explicit-constructor): converts all features to a view.
  FeaturesView(const StereoFeatures& of) : points(of.points), lines(of.lines), image(of.image) {}
};

inline StereoFeatures OwnFeatures(const FeaturesView& view) {
  return {{view.points.begin(), view.points.end()}, {view.lines.begin(), view.lines.end()}, view.image};
}

/// Returns the camera in which features are expressed, with the image in which they were detected.
inline StereoCamera CameraOf(const FeaturesView& features, const StereoCamera& camera) {
  return features.image ? camera.With(*features.image) : camera;
}

}  // namespace plslam
