// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "core/ids/ids.h"
#include "mapping_process/insertion/landmark_creation.h"

namespace plslam::mapping {

/// A segment observed in a keyframe.
struct SegmentView {
  SE3 T_w_kf;
  Segment2 segment;
  double sigma_px = 1.0;
};

/// The part of a 3D line that `first` observes, at the intersection of its viewing plane with that of `second`, with
/// endpoint covariances from both.
struct TriangulatedLine {
  Segment3 segment_w;
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
};
/// Returns nullopt if the planes meet at less than `min_angle_rad`, the segment would be behind a camera, or the views
/// do not overlap along it.
std::optional<TriangulatedLine> TriangulateLine(const SegmentView& first, const SegmentView& second,
                                                const StereoCamera& camera, double min_angle_rad);

/// Creates landmarks from segments without stereo depth (nearly parallel to the baseline): triangulates pairs of
/// segments of the keyframe and its neighbours with similar descriptors, and keeps those that a third keyframe
/// observes, too. Returns their ids.
std::vector<LandmarkId> TriangulateLines(KeyframeId keyframe_id, const KeyframeFeatures& features,
                                         const StereoCamera& camera, const MappingOptions& options, LandmarkIds& ids,
                                         Map& map);

}  // namespace plslam::mapping
