// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "vo_process/tracking/row_calibration.h"

namespace plslam::vo {
namespace {

constexpr int kMinInOctave = 3;
// Neighbours that a match of a body has: how many, how near, and how alike they move.
constexpr int kMinTogether = 2;
constexpr double kTogetherRadius_px = 160.0;
constexpr double kTogether_px = 4.0;
constexpr double kTogetherRatio = 0.15;
// Around what a body is seen as, features at the same depth are taken for the body's.
constexpr double kSurrounding_px = 50.0;
constexpr double kSameDepthRatio = 0.1;
constexpr double kSameDepth_px = 1.5;
constexpr int kMinAround = 2;

}  // namespace

Spread SpreadOf(const FrameMatches& matches, const TrackedFrame& frame, const StereoCamera& camera) {
  std::set<int> cells;
  std::array<int, 16> in_octave{};
  const auto add = [&](const Eigen::Vector2d& px, double disparity_px) {
    cells.insert(CellOf(px, camera));
    if (disparity_px > 0.0) ++in_octave[std::clamp(static_cast<int>(std::log2(disparity_px)) + 4, 0, 15)];
  };
  for (const LandmarkMatch& match : matches.points) {
    const StereoPoint& point = frame.features.points[match.feature];
    add(point.left.px, point.disparity_px);
  }
  for (const LandmarkMatch& match : matches.lines) {
    const StereoLine& line = frame.features.lines[match.feature];
    add(0.5 * (line.left.segment.p + line.left.segment.q), line.MiddleDisparity_px());
  }
  const auto octaves = std::count_if(in_octave.begin(), in_octave.end(), [](int n) { return n >= kMinInOctave; });
  return {static_cast<int>(cells.size()), static_cast<int>(octaves)};
}

std::vector<LandmarkMatch> MovingTogether(const PointLandmarks& landmarks, const SE3& T_c_odom,
                                          const std::vector<LandmarkMatch>& matches, const TrackedFrame& frame,
                                          const StereoCamera& camera) {
  struct Flow {
    Eigen::Vector2d px;
    Eigen::Vector2d moved_px;
    double disparity_px;
  };
  std::vector<Flow> flows;
  flows.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    const StereoPoint& seen = frame.features.points[match.feature];
    const Eigen::Vector3d uvd = camera.ProjectStereo(T_c_odom * landmarks.landmarks()[match.landmark].p_odom);
    flows.push_back({seen.left.px, seen.left.px - uvd.head<2>(), uvd.z()});
  }
  std::vector<LandmarkMatch> together;
  for (size_t i = 0; i < flows.size(); ++i) {
    int near = 0;
    for (size_t j = 0; j < flows.size() && near < kMinTogether; ++j) {
      const double allowed_px = kTogether_px + kTogetherRatio * flows[i].moved_px.norm();
      if (i != j && (flows[i].px - flows[j].px).norm() < kTogetherRadius_px &&
          (flows[i].moved_px - flows[j].moved_px).norm() < allowed_px &&
          std::abs(flows[i].disparity_px - flows[j].disparity_px) < kSameDepth_px + 0.3 * flows[i].disparity_px) {
        ++near;
      }
    }
    if (near >= kMinTogether) together.push_back(matches[i]);
  }
  return together;
}

int FeaturePlaces::Owner(const Eigen::Vector2d& px, double disparity_px, int times) const {
  std::array<int, kMaxBodies> of_body{};
  int of_world = 0;
  for (const Place& place : places_) {
    const double squared = (place.px - px).squaredNorm();
    if (squared > kSurrounding_px * kSurrounding_px || squared == 0.0) continue;
    const double allowed = kSameDepth_px + kSameDepthRatio * std::max(disparity_px, place.disparity_px);
    const bool comparable = disparity_px > 0.0 && place.disparity_px > 0.0;
    if (comparable && std::abs(place.disparity_px - disparity_px) > allowed) continue;
    ++(place.body < 0 ? of_world : of_body[static_cast<size_t>(place.body)]);
  }
  const auto most = std::max_element(of_body.begin(), of_body.end());
  if (*most < kMinAround || *most <= times * of_world) return -1;
  return static_cast<int>(most - of_body.begin());
}

int FeaturePlaces::Owner(const StereoLine& line, int times) const {
  const Segment2& segment = line.left.segment;
  const std::array<int, 3> owners{Owner(segment.p, line.HasDepth() ? line.disparity_p_px : -1.0, times),
                                  Owner(0.5 * (segment.p + segment.q), line.MiddleDisparity_px(), times),
                                  Owner(segment.q, line.HasDepth() ? line.disparity_q_px : -1.0, times)};
  if (owners[0] == owners[1] || owners[0] == owners[2]) return owners[0];
  return owners[1] == owners[2] ? owners[1] : -1;
}

}  // namespace plslam::vo
