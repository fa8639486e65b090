// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/stereo_camera.h"
#include "mapping_process/insertion/landmark_creation.h"

namespace plslam::mapping {

/// A segment seen from a keyframe.
struct SegmentView {
  SE3 T_w_kf;
  Segment2 segment;
  double sigma_px = 1.0;
};

/// The part of a line in space that `first` sees, where its viewing plane meets that of `second`; covariances of the
/// endpoints from the uncertainty of both. nullopt where the planes meet at less than `min_angle_rad`, the segment
/// would be behind a camera, or the views do not overlap along it.
struct TriangulatedLine {
  Segment3 segment_w;
  Eigen::Matrix3d covariance_p = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d covariance_q = Eigen::Matrix3d::Zero();
};
std::optional<TriangulatedLine> TriangulateLine(const SegmentView& first, const SegmentView& second,
                                                const StereoCamera& camera, double min_angle_rad);

/// Landmarks from segments that have no depth from one pair (nearly parallel to the baseline): segments of the
/// keyframe and of its neighbours that look alike are triangulated, and count where a third keyframe sees the result
/// too.
std::vector<int64_t> TriangulateLines(int64_t keyframe_id, const KeyframeFeatures& features,
                                      const StereoCamera& camera, const MappingOptions& options, LandmarkIds& ids,
                                      Map& map);

}  // namespace plslam::mapping
