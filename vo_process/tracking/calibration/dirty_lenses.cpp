// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/calibration/dirty_lenses.h"

#include <algorithm>

#include "core/features/matching/descriptor_matcher.h"
#include "vo_process/stereo/point_stereo.h"

namespace plslam::vo {
namespace {

// Distance from a partner within which a corner of the right image is the same: detectors differ.
constexpr double kPartner_px = 4.0;

// Largest disparity at which a partner is expected, as a share of the image's width.
constexpr double kMostDisparity = 0.125;

bool IsMatched(const StereoPoint& point) { return point.HasDepth() || point.is_far; }

/// Pixel of the partner in the right image, of a point that has one.
Eigen::Vector2d PartnerOf(const StereoPoint& point) {
  return point.left.px + Eigen::Vector2d(-std::max(point.disparity_px, 0.0), point.row_offset_px);
}

/// Whether the mask of the other image may hide the partner of a corner: at no, a middle or a large disparity.
/// `side`: 1 for a corner of the right image, -1 for one of the left image.
bool IsPartnerHidden(const Eigen::Vector2d& px, const FeatureMask& other_mask, double side) {
  const int width_px = other_mask.inside().cols;
  for (const double share : {0.0, 0.5, 1.0}) {
    const Eigen::Vector2d partner = px + Eigen::Vector2d(side * share * kMostDisparity * width_px, 0.0);
    if (partner.x() >= 0.0 && partner.x() < width_px - 1 && other_mask.IsOutside(partner)) return true;
  }
  return false;
}

// Dirt on one lens matches dirt on the other, so a partner on known dirt is none.

std::vector<LensCorner> LeftCorners(const StereoFeatures& features, const LensDirt& right_dirt,
                                    const FeatureMask& right_mask) {
  std::vector<LensCorner> corners;
  corners.reserve(features.points.size());
  for (const StereoPoint& point : features.points) {
    const bool is_matched = IsMatched(point) && !right_dirt.IsOnDirt(PartnerOf(point));
    if (is_matched || !IsPartnerHidden(point.left.px, right_mask, -1.0))
      corners.push_back({point.left.px, is_matched});
  }
  return corners;
}

std::vector<LensCorner> RightCorners(const StereoFeatures& features,
                                     const std::vector<Eigen::Vector2d>& right_corners, const LensDirt& left_dirt,
                                     const FeatureMask& left_mask) {
  std::vector<LensCorner> corners;
  std::vector<PointFeature> partners;
  for (const StereoPoint& point : features.points) {
    if (!IsMatched(point) || left_dirt.IsOnDirt(point.left.px)) continue;
    corners.push_back({PartnerOf(point), true});
    partners.emplace_back().px = PartnerOf(point);
  }
  const PointGrid grid(partners);
  for (const Eigen::Vector2d& px : right_corners) {
    if (grid.Within(px, kPartner_px).empty() && !IsPartnerHidden(px, left_mask, 1.0)) corners.push_back({px, false});
  }
  return corners;
}

}  // namespace

void DirtyLenses::Observe(const StereoFeatures& features, const std::vector<Eigen::Vector2d>& right_corners,
                          const FeatureMask& left_mask, const FeatureMask& right_mask) {
  if (!right_corners.empty()) right_.Observe(RightCorners(features, right_corners, left_, left_mask));
  left_.Observe(LeftCorners(features, right_, right_mask));
}

int DirtyLenses::Remove(StereoFeatures& features) const {
  const auto n_removed =
      std::erase_if(features.points, [this](const StereoPoint& point) { return left_.IsOnDirt(point.left.px); });
  std::erase_if(features.lines, [this](const StereoLine& line) {
    return left_.IsOnDirt(line.left.segment.p) && left_.IsOnDirt(line.left.segment.q);
  });
  if (!right_.HasDirt()) return static_cast<int>(n_removed);
  for (StereoPoint& point : features.points) {
    if (point.HasDepth() && right_.IsOnDirt(PartnerOf(point))) ForgetPartner(point);
  }
  for (StereoLine& line : features.lines) {
    if (!line.HasDepth()) continue;
    const Eigen::Vector2d p = line.left.segment.p - Eigen::Vector2d(line.disparity_p_px, 0.0);
    const Eigen::Vector2d q = line.left.segment.q - Eigen::Vector2d(line.disparity_q_px, 0.0);
    if (right_.IsOnDirt(p) && right_.IsOnDirt(q)) line.disparity_p_px = line.disparity_q_px = -1.0;
  }
  return static_cast<int>(n_removed);
}

}  // namespace plslam::vo
