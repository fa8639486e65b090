// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "mapping_process/insertion/landmark_creation.h"

namespace plslam::mapping {

/// A segment observed in a keyframe. The covariance is of the right perturbation of the pose, given the landmarks.
struct SegmentView {
  SE3 T_w_kf;
  Matrix6d covariance = Matrix6d::Zero();
  Segment2 segment;
  double sigma_px = 1.0;
};

/// The part of a 3D line that `first` observes, at the intersection of its viewing plane with that of `second`, with
/// endpoint covariances, given the pose of `first`, from the segments and the poses of both.
struct TriangulatedLine {
  Segment3 segment_w;
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
};
/// Returns nullopt if the planes meet at less than `min_angle_rad`, the segment would be behind a camera, the views do
/// not overlap along it, or the sigma of the depth of an endpoint is more than this share of it: views from almost one
/// position tell no depth, whatever the angle between their planes.
std::optional<TriangulatedLine> TriangulateLine(const SegmentView& first, const SegmentView& second,
                                                const StereoCamera& camera, double min_angle_rad,
                                                double max_relative_depth_sigma);

/// Creates landmarks from segments without stereo depth (nearly parallel to the baseline): triangulates pairs of
/// segments of the keyframe and its neighbours with similar descriptors, and keeps those that a third keyframe
/// observes, too. Returns their ids. `pose_covariance` is that of the keyframe given its landmarks; its neighbours,
/// which observe the same, count as equally uncertain.
std::vector<LandmarkId> TriangulateLines(KeyframeId keyframe_id, const Matrix6d& pose_covariance,
                                         const KeyframeFeatures& features, const StereoCamera& camera,
                                         const MappingOptions& options, LandmarkIds& ids, Map& map);

}  // namespace plslam::mapping
