// SPDX-License-Identifier: BSD-3-Clause
#include "tools/export/picture_check.h"

#include <algorithm>

#include "core/features/points/orb_extractor.h"

namespace plslam::exports {
namespace {

// A keyframe stores the mean position over some frames.
constexpr double kNear_px = 3.0;
// Of 256 bits; descriptors of other corners differ in 128 on average, and 64 is four standard deviations from that.
constexpr int kAlike = 64;
constexpr size_t kLeastPoints = 20;
// In the right image most points are found again, in another one less than 2 % by chance.
constexpr double kLeastShare = 0.15;

}  // namespace

bool ShowsKeyframe(const cv::Mat& image, const FeaturesView& features) {
  if (features.points.size() < kLeastPoints) return false;
  const std::vector<PointFeature> seen = OrbExtractor(OrbOptions()).Extract(image);
  const auto is_seen = [&](const StereoPoint& point) {
    return std::ranges::any_of(seen, [&](const PointFeature& other) {
      return (other.px - point.left.px).squaredNorm() < kNear_px * kNear_px &&
             HammingDistance(other.descriptor, point.left.descriptor) <= kAlike;
    });
  };
  const auto n = std::ranges::count_if(features.points, is_seen);
  return static_cast<double>(n) >= kLeastShare * static_cast<double>(features.points.size());
}

}  // namespace plslam::exports
