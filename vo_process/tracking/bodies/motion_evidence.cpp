// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/bodies/motion_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/motion/robust.h"
#include "vo_process/tracking/calibration/row_calibration.h"

namespace plslam::vo {
namespace {

constexpr int kMinInOctave = 3;
// Neighbours that support a match of a body: their number, distance, and similarity of motion.
constexpr int kMinTogether = 2;
constexpr double kTogetherRadius_px = 160.0;
constexpr double kTogether_px = 4.0;
constexpr double kTogetherRatio = 0.15;
// Radius around features of a body within which features at the same depth belong to the body.
constexpr double kSurrounding_px = 50.0;
constexpr double kSameDepthRatio = 0.1;
constexpr double kSameDepth_px = 1.5;
constexpr int kMinAround = 2;
// Number of sigmas by which a disparity offset may differ from its estimate, and the remaining difference in pixels.
constexpr double kOffsetSigmas = 3.0;
constexpr double kAlike_px = 2.0;

/// Median disparity of the matched points; 0 without any.
double MedianDisparity(const FrameMatches& matches, const TrackedFrame& frame) {
  std::vector<double> disparities;
  for (const LandmarkMatch& match : matches.points) {
    const StereoPoint& point = frame.features.points[match.feature];
    if (point.HasDepth()) disparities.push_back(point.disparity_px);
  }
  return disparities.empty() ? 0.0 : Median(disparities);
}

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

bool IsExpected(const SE3& T_odom_c, const SE3& T_odom_prev, const MotionPrediction& prediction) {
  return SquaredDeviation(prediction, T_odom_prev * prediction.T_prev_c, T_odom_c) <= kExpectedChi2;
}

// An offset b of the disparities scales the translation from points at disparity d by 1 - b / d. Two motions in the
// same direction determine b, which explains them if it is within the uncertainty of the calibration.
bool IsDisparityOffset(const SE3& T_odom_prev, const LocalLandmarks& world, const TrackedFrame& frame,
                       const Alignment& first, const FrameMatches& of_first, const Alignment& second,
                       const DisparityCalibration& calibration, const StereoCamera& camera) {
  const SE3 T_prev_c = T_odom_prev.Inverse() * first.T_odom_c;
  const SE3 T_prev_c_second = T_odom_prev.Inverse() * second.T_odom_c;
  const double length = T_prev_c.translation().norm();
  const double d_first = MedianDisparity(of_first, frame);
  const double d_second = MedianDisparity(second.matches, frame);
  if (!(length > 0.0 && d_first > 0.0 && d_second > 0.0)) return false;
  const double ratio = T_prev_c.translation().dot(T_prev_c_second.translation()) / (length * length);
  const double offset_px = (ratio - 1.0) / (ratio / d_first - 1.0 / d_second);
  const DisparityCalibration::Rest rest = calibration.RestAt(0.5 * camera.width_px);
  if (!(std::abs(offset_px - rest.mean_px) < kOffsetSigmas * rest.sigma_px)) return false;
  const SE3 T_prev_c_scaled(T_prev_c.rotation(), ratio * T_prev_c.translation());
  std::vector<double> differences;
  for (const LandmarkMatch& match : second.matches.points) {
    const Eigen::Vector3d& p_odom = world.points.landmarks()[match.landmark].p_odom;
    const Eigen::Vector3d p_prev = T_odom_prev.Inverse() * p_odom;
    const Eigen::Vector3d p_c = T_prev_c_scaled.Inverse() * p_prev;
    const Eigen::Vector3d p_c_second = T_prev_c_second.Inverse() * p_prev;
    if (std::min(p_c.z(), p_c_second.z()) < camera.MinDepth()) continue;
    differences.push_back((camera.Project(p_c) - camera.Project(p_c_second)).norm());
  }
  return !differences.empty() && Median(differences) < kAlike_px;
}

}  // namespace plslam::vo
