// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/dirty_lenses.h"

#include <algorithm>

#include "core/features/matching/descriptor_matcher.h"

namespace plslam::vo {
namespace {

// Distance from a partner within which a corner of the right image is the same: detectors differ.
constexpr double kPartner_px = 4.0;

bool IsMatched(const StereoPoint& point) { return point.HasDepth() || point.is_far; }

/// Pixel of the partner in the right image, of a point that has one.
Eigen::Vector2d PartnerOf(const StereoPoint& point) {
  return point.left.px + Eigen::Vector2d(-std::max(point.disparity_px, 0.0), point.row_offset_px);
}

// Dirt on one lens matches dirt on the other, so a partner on known dirt is none.

std::vector<LensCorner> LeftCorners(const StereoFeatures& features, const LensDirt& right_dirt) {
  std::vector<LensCorner> corners;
  corners.reserve(features.points.size());
  for (const StereoPoint& point : features.points) {
    corners.push_back({point.left.px, IsMatched(point) && !right_dirt.IsOnDirt(PartnerOf(point))});
  }
  return corners;
}

std::vector<LensCorner> RightCorners(const StereoFeatures& features,
                                     const std::vector<Eigen::Vector2d>& right_corners, const LensDirt& left_dirt) {
  std::vector<LensCorner> corners;
  std::vector<PointFeature> partners;
  for (const StereoPoint& point : features.points) {
    if (!IsMatched(point) || left_dirt.IsOnDirt(point.left.px)) continue;
    corners.push_back({PartnerOf(point), true});
    partners.emplace_back().px = PartnerOf(point);
  }
  const PointGrid grid(partners);
  for (const Eigen::Vector2d& px : right_corners) {
    if (grid.Within(px, kPartner_px).empty()) corners.push_back({px, false});
  }
  return corners;
}

}  // namespace

void DirtyLenses::Observe(const StereoFeatures& features, const std::vector<Eigen::Vector2d>& right_corners) {
  if (!right_corners.empty()) right_.Observe(RightCorners(features, right_corners, left_));
  left_.Observe(LeftCorners(features, right_));
}

void DirtyLenses::RemoveFrom(StereoFeatures& features) {
  n_removed_ = static_cast<int>(
      std::erase_if(features.points, [this](const StereoPoint& point) { return left_.IsOnDirt(point.left.px); }));
  std::erase_if(features.lines, [this](const StereoLine& line) {
    return left_.IsOnDirt(line.left.segment.p) && left_.IsOnDirt(line.left.segment.q);
  });
  if (!right_.HasDirt()) return;
  for (StereoPoint& point : features.points) {
    if (!point.HasDepth() || !right_.IsOnDirt(PartnerOf(point))) continue;
    point.disparity_px = -1.0;
    point.row_offset_px = 0.0;
    point.sigma_row_px = -1.0;
  }
  for (StereoLine& line : features.lines) {
    if (!line.HasDepth()) continue;
    const Eigen::Vector2d p = line.left.segment.p - Eigen::Vector2d(line.disparity_p_px, 0.0);
    const Eigen::Vector2d q = line.left.segment.q - Eigen::Vector2d(line.disparity_q_px, 0.0);
    if (right_.IsOnDirt(p) && right_.IsOnDirt(q)) line.disparity_p_px = line.disparity_q_px = -1.0;
  }
}

}  // namespace plslam::vo
