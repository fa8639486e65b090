// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/line_extent.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/features/matching/segment_projection.h"

namespace plslam::mapping {
namespace {

constexpr double kBorder_px = 12.0;
// Relative to the segment's length: largest movement of an end in one call, and least remaining length.
constexpr double kMaxStep = 1.0;
constexpr double kMinRest = 0.2;

/// Ends of the observed segments, as parameter s of the line p + s (q - p).
struct Ends {
  std::vector<double> at_p;  ///< observed endpoints
  std::vector<double> at_q;
  std::vector<double> beyond_p;  ///< cut off by the image border
  std::vector<double> beyond_q;
};

bool AtBorder(const Eigen::Vector2d& px, const StereoCamera& camera) { return !camera.InImage(px, kBorder_px); }

Ends CollectEnds(const MapLine& line, const KeyframeFeatures& features, const StereoCamera& camera, const Map& map) {
  Ends ends;
  for (const Observation& observation : line.observations) {
    const SE3 T_kf_w = map.FindKeyframe(observation.keyframe_id())->T_w_kf.Inverse();
    const Segment3 in_camera{T_kf_w * line.segment_w.p, T_kf_w * line.segment_w.q};
    const FeaturesView& of_keyframe = features.at(observation.keyframe_id());
    const Segment2& seen = of_keyframe.lines[static_cast<size_t>(observation.feature)].left.segment;
    const StereoCamera looked = CameraOf(of_keyframe, camera);
    const auto s_p = AlongLine(in_camera, seen.p, camera);
    const auto s_q = AlongLine(in_camera, seen.q, camera);
    if (!s_p || !s_q || *s_p >= *s_q) continue;
    (AtBorder(seen.p, looked) ? ends.beyond_p : ends.at_p).push_back(*s_p);
    (AtBorder(seen.q, looked) ? ends.beyond_q : ends.at_q).push_back(*s_q);
  }
  return ends;
}

// Returns the second largest value, the largest that two views confirm; the only one if there is one.
std::optional<double> Outermost(std::vector<double> reached) {
  if (reached.empty()) return std::nullopt;
  std::sort(reached.begin(), reached.end(), std::greater<>());
  return reached[std::min<size_t>(1, reached.size() - 1)];
}

// Combines observed endpoints with cut-off ones that lie farther out. If all are cut off, the segment keeps at least
// its extent.
std::optional<double> EndOf(std::vector<double> seen, const std::vector<double>& beyond, double now) {
  const auto end = Outermost(seen);
  if (!end && !beyond.empty()) return std::max(now, *Outermost(beyond));
  for (const double s : beyond) {
    if (s > *end) seen.push_back(s);
  }
  return Outermost(std::move(seen));
}

std::vector<double> Negated(std::vector<double> values) {
  for (double& value : values) value = -value;
  return values;
}

Eigen::Matrix3d CovarianceAt(const MapLine& line, double s) {
  return (1.0 - s) * (1.0 - s) * line.covariance_p.matrix() + s * s * line.covariance_q.matrix();
}

}  // namespace

void ExtendAndTrim(const std::vector<LandmarkId>& line_ids, const KeyframeFeatures& features,
                   const StereoCamera& camera, Map& map) {
  for (const LandmarkId id : line_ids) {
    const MapLine* found = map.FindLine(id);
    if (found == nullptr || found->observations.size() < 2) continue;
    const MapLine line = *found;
    const Ends ends = CollectEnds(line, features, camera, map);
    const auto minus_from = EndOf(Negated(ends.at_p), Negated(ends.beyond_p), 0.0);
    const auto to = EndOf(ends.at_q, ends.beyond_q, 1.0);
    if (!minus_from || !to) continue;
    const double s_p = std::clamp(-*minus_from, -kMaxStep, kMaxStep);
    const double s_q = std::clamp(*to, 1.0 - kMaxStep, 1.0 + kMaxStep);
    if (!(s_q - s_p >= kMinRest)) continue;
    const Eigen::Vector3d along = line.segment_w.q - line.segment_w.p;
    map.SetSegment(id, {line.segment_w.p + s_p * along, line.segment_w.p + s_q * along}, CovarianceAt(line, s_p),
                   CovarianceAt(line, s_q));
  }
}

}  // namespace plslam::mapping
