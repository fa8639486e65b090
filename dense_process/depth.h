// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "core/features/features.h"
#include "core/geometry/se3.h"
#include "core/geometry/stereo_camera.h"
#include "dense_process/row_offsets.h"
#include "dense_process/volume.h"

namespace plslam::dense {

/// Largest standard deviation of depth in use, in voxels.
inline constexpr double kSigmasInVoxels = 2.5;

/// Depth of the rectified left image.
struct DepthImage {
  cv::Mat z_m;      ///< CV_32FC1; 0: unknown
  cv::Mat sigma_m;  ///< its standard deviation, where it is known
  /// Lower bounds of the depth where the image is blank: the least depth on all four sides; 0: none. A blank object in
  /// front of its surroundings would have an edge, whose depth is known.
  cv::Mat at_least_m;
  /// Vertical disparity of the pair, which was corrected before it was matched.
  RowOffsets rows;
  /// Comparison with the disparities of the keyframe's points: their number, and the share that has depth within 1 px.
  /// From a depth sensor: no points.
  int n_compared = 0;
  double agreement = 0.0;
  /// Lines that have depth at their middle. Lines are often the border of a surface, where there is none.
  int n_lines_compared = 0;
  /// The median difference to points and lines (matched minus measured, already removed from `z_m`), and the ratio of
  /// the differences to the standard deviations from the images alone, by which those were multiplied.
  double offset_px = 0.0;
  double sigma_scale = 1.0;
};

/// Depth by semi-global matching (Hirschmueller 2008) of an 8-bit rectified pair. `features` of the left image bound
/// the disparities and measure their error. Unknown: where `in_use` (empty: everywhere) is 0, where the image has no
/// texture along the row, at borders between surfaces, and where left and right disagree.
DepthImage MatchPair(const cv::Mat& left, const cv::Mat& right, const cv::Mat& in_use, const StereoCamera& camera,
                     const StereoFeatures& features);

/// Depth of a sensor: 16 bits, 0 unknown, `units_per_m`; without the borders between surfaces.
DepthImage FromSensor(const cv::Mat& depth16, double units_per_m);

/// Surface points of an image, one for each voxel that the volume of the rays would have, in its frame s; ordered by
/// their first pixel. Depth beyond `range_m`, or with a standard deviation of more than 2.5 voxels, is left out.
std::vector<DepthRay> MakeRays(const DepthImage& depth, const cv::Mat& grey, const StereoCamera& camera,
                               const SE3& T_s_c, double voxel_m, double range_m);

/// Ends of rays through blank pixels, up to the lower bounds of their depth, in frame s: one for each voxel,
/// ordered by their first pixel. Empty: no pixel has a bound.
std::vector<Eigen::Vector3d> MakeBoundEnds(const DepthImage& depth, const StereoCamera& camera, const SE3& T_s_c,
                                           double voxel_m, double range_m);

}  // namespace plslam::dense
