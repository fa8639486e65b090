// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/local_window.h"

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <utility>

#include "core/geometry/triangulation.h"
#include "core/localisation/local_map.h"
#include "core/map/landmark_types.h"
#include "mapping_process/insertion/observations.h"

namespace plslam::mapping {
namespace {

// Standard deviation above which a pose counts as undetermined.
constexpr double kUnknown_m = 100.0;
// Number of first keyframes of a session whose local windows are widened if they contain another session, and the
// factor of widening.
constexpr int64_t kSeamKeyframes = 10;
constexpr int kSeamFactor = 2;
// Share of the landmarks of the best keyframe from which one of an earlier visit is a constant keyframe.
constexpr double kWellShared = 0.25;

// Whether a session begins among keyframes of another one: only landmarks connect them, no motion.
bool IsSeam(std::span<const KeyframeId> keyframes, const Map& map) {
  const MapKeyframe& newest = *map.FindKeyframe(keyframes.front());
  return newest.name.number < kSeamKeyframes && std::any_of(keyframes.begin(), keyframes.end(), [&](KeyframeId id) {
           return map.FindKeyframe(id)->name.session != newest.name.session;
         });
}

// Landmarks that at least two keyframes observe, one of them free. If they, or their observations in a window of this
// size, exceed the maximum, those with most observations.
template <class Type>
std::vector<LandmarkId> SeenTwice(const std::vector<KeyframeId>& free, const Map& map, size_t window_size,
                                  int max_count, int max_observations) {
  std::vector<std::pair<size_t, LandmarkId>> ranked;
  for (const LandmarkId id : SeenBy<Type>(free, map)) {
    const size_t n_observations = Type::Find(map, id)->observations.size();
    if (n_observations >= 2) ranked.emplace_back(n_observations, id);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<LandmarkId> chosen;
  size_t total = 0;
  for (const auto& [n_observations, id] : ranked) {
    total += std::min(n_observations, window_size);
    if (chosen.size() >= static_cast<size_t>(max_count) || total > static_cast<size_t>(max_observations)) break;
    chosen.push_back(id);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

using IsEarlierVisit = std::function<bool(KeyframeId)>;

// The oldest views of earlier visits first, because the errors of newer ones depend on them: without them the place
// would drift with each visit. Then those that observe most of the landmarks.
std::vector<KeyframeId> FixedKeyframes(const std::vector<KeyframeId>& free, const std::vector<LandmarkId>& points,
                                       const std::vector<LandmarkId>& lines, const Map& map,
                                       const IsEarlierVisit& is_earlier, int max_count) {
  std::map<KeyframeId, int> counts;
  CountKeyframes<PointType>(points, map, counts);
  CountKeyframes<LineType>(lines, map, counts);
  for (const KeyframeId id : free) counts.erase(id);
  int most = 0;
  for (const auto& [id, count] : counts) most = std::max(most, count);
  std::vector<KeyframeId> fixed;
  for (const auto& [id, count] : counts) {
    if (static_cast<int>(fixed.size()) == max_count) return fixed;
    if (count >= kWellShared * most && is_earlier(id)) fixed.push_back(id);
  }
  for (const KeyframeId id : fixed) counts.erase(id);
  const std::vector<KeyframeId> others = MostCounted(counts, max_count - static_cast<int>(fixed.size()));
  fixed.insert(fixed.end(), others.begin(), others.end());
  return fixed;
}

// Marks constant keyframes of the window: those after the first `n_free`, those of earlier visits, whose place was
// adjusted then, and the first of the map. If there are none, the oldest is constant, to fix the gauge.
std::vector<bool> ConstantKeyframes(const std::vector<KeyframeId>& keyframes, size_t n_free, const Map& map,
                                    const IsEarlierVisit& is_earlier) {
  const KeyframeId first = map.keyframes().begin()->first;
  std::vector<bool> constant(keyframes.size());
  for (size_t i = 0; i < keyframes.size(); ++i) {
    constant[i] = i >= n_free || keyframes[i] == first || is_earlier(keyframes[i]);
  }
  if (std::find(constant.begin(), constant.end(), true) == constant.end()) {
    const auto oldest = std::min_element(keyframes.begin(), keyframes.end());
    constant[static_cast<size_t>(oldest - keyframes.begin())] = true;
  }
  return constant;
}

// Whether a landmark that is not adjusted moves with this keyframe, its newest observer.
template <class Landmark>
bool GoesWith(const Landmark& landmark, KeyframeId keyframe_id, const std::vector<LandmarkId>& adjusted) {
  return landmark.observations.back().keyframe_id() == keyframe_id &&
         !std::binary_search(adjusted.begin(), adjusted.end(), landmark.id);
}

// Landmarks that are not adjusted keep their position relative to their newest keyframe.
void MoveOthers(KeyframeId keyframe_id, const SE3& T_new_old, const MapBundle& window, Map& map) {
  const Eigen::Matrix3d R = T_new_old.R();
  for (const LandmarkId id : PointType::Of(map, keyframe_id)) {
    if (id < 0 || !GoesWith(*map.FindPoint(id), keyframe_id, window.points)) continue;
    const MapPoint& point = *map.FindPoint(id);
    map.SetPosition(id, T_new_old * point.p_w, RotateCovariance(R, point.covariance));
  }
  for (const LandmarkId id : LineType::Of(map, keyframe_id)) {
    if (id < 0 || !GoesWith(*map.FindLine(id), keyframe_id, window.lines)) continue;
    const MapLine& line = *map.FindLine(id);
    map.SetSegment(id, {T_new_old * line.segment_w.p, T_new_old * line.segment_w.q},
                   RotateCovariance(R, line.covariance_p), RotateCovariance(R, line.covariance_q));
  }
}

template <class Type>
int DropOutliers(const MapBundle& window, const std::vector<LandmarkId>& ids, const std::vector<bool>& inliers,
                 const KeyframeFeatures& features, Map& map) {
  std::vector<std::pair<LandmarkId, KeyframeId>> outliers;
  size_t i = 0;
  ForEachObservation<Type>(window, ids, map, features, [&](int, int landmark, const Observation& observation) {
    if (!inliers[i++]) outliers.emplace_back(ids[static_cast<size_t>(landmark)], observation.keyframe_id());
  });
  for (const auto& [landmark_id, keyframe_id] : outliers)
    DropObservation<Type>(landmark_id, keyframe_id, features, map);
  return static_cast<int>(outliers.size());
}

// Whether the covariance is that of a pose without observations (`BundleResult`).
bool IsUnknown(const Matrix6d& covariance) { return covariance.trace() > kUnknown_m * kUnknown_m; }

// Covariances of the adjustment are relative to the constant keyframes: they are composed with the covariance of one
// of these. A keyframe constrained by its motion alone keeps its covariance.
void MoveKeyframes(const MapBundle& window, const BundleResult& result, Map& map) {
  const auto& poses = window.problem.poses;
  const auto fixed = std::find_if(poses.begin(), poses.end(), [](const BundlePose& pose) { return pose.fixed; });
  const MapKeyframe anchor = *map.FindKeyframe(window.keyframes[static_cast<size_t>(fixed - poses.begin())]);
  for (size_t i = 0; i < window.keyframes.size(); ++i) {
    if (window.problem.poses[i].fixed) continue;
    const KeyframeId id = window.keyframes[i];
    const SE3 T_new_old = result.T_w_c[i] * window.problem.poses[i].T_w_c.Inverse();
    MoveOthers(id, T_new_old, window, map);
    const SE3 T_anchor_kf = anchor.T_w_kf.Inverse() * result.T_w_c[i];
    const Matrix6d& covariance = result.pose_covariances[i];
    map.SetPose(id, result.T_w_c[i],
                IsUnknown(covariance) ? map.FindKeyframe(id)->covariance
                                      : ComposeCovariance(anchor.covariance, T_anchor_kf, covariance));
  }
}

}  // namespace

MapBundle MakeLocalWindow(KeyframeId keyframe_id, const Map& map, const KeyframeFeatures& features,
                          const Visits& visits, const StereoCamera& camera, const WindowOptions& options) {
  std::vector<KeyframeId> keyframes =
      KeyframesAround(keyframe_id, map, options.min_shared, kSeamFactor * options.keyframes);
  const size_t usual = std::min(keyframes.size(), static_cast<size_t>(options.keyframes));
  const bool at_seam = IsSeam({keyframes.data(), usual}, map);
  if (!at_seam) keyframes.resize(usual);
  const size_t n_free = keyframes.size();
  const int factor = at_seam ? kSeamFactor : 1;
  const int n_fixed = factor * options.fixed_keyframes;
  const size_t size = n_free + static_cast<size_t>(n_fixed);
  std::vector<LandmarkId> points =
      SeenTwice<PointType>(keyframes, map, size, options.max_points, factor * options.max_point_observations);
  std::vector<LandmarkId> lines =
      SeenTwice<LineType>(keyframes, map, size, options.max_lines, factor * options.max_line_observations);
  const MapKeyframe& newest = *map.FindKeyframe(keyframe_id);
  const auto is_earlier = [&](KeyframeId id) { return visits.IsBefore(*map.FindKeyframe(id), newest); };
  const std::vector<KeyframeId> fixed = FixedKeyframes(keyframes, points, lines, map, is_earlier, n_fixed);
  keyframes.insert(keyframes.end(), fixed.begin(), fixed.end());
  const std::vector<bool> constant = ConstantKeyframes(keyframes, n_free, map, is_earlier);
  return MakeMapBundle(map, features, camera, std::move(keyframes), constant, std::move(points), std::move(lines),
                       options.relative_sigma);
}

MapBundle MakeLandmarkWindow(const LandmarksNamed& landmarks, const Map& map, const KeyframeFeatures& features,
                             const StereoCamera& camera) {
  std::set<KeyframeId> seeing;
  const auto see = [&seeing](const std::vector<Observation>& observations) {
    for (const Observation& observation : observations) seeing.insert(observation.keyframe_id());
  };
  for (const LandmarkId id : landmarks.points) see(map.FindPoint(id)->observations);
  for (const LandmarkId id : landmarks.lines) see(map.FindLine(id)->observations);
  std::vector<KeyframeId> keyframes(seeing.begin(), seeing.end());
  const std::vector<bool> constant(keyframes.size(), true);
  return MakeMapBundle(map, features, camera, std::move(keyframes), constant, landmarks.points, landmarks.lines, 0.0);
}

AdjustmentFigures ApplyAdjustment(const MapBundle& window, const BundleResult& result,
                                  const KeyframeFeatures& features, Map& map) {
  AdjustmentFigures figures;
  if (!result.ok) return figures;
  const auto& poses = window.problem.poses;
  figures.n_fixed_keyframes =
      static_cast<int>(std::count_if(poses.begin(), poses.end(), [](const BundlePose& pose) { return pose.fixed; }));
  figures.n_keyframes = static_cast<int>(poses.size()) - figures.n_fixed_keyframes;
  figures.n_points = static_cast<int>(window.points.size());
  figures.n_lines = static_cast<int>(window.lines.size());
  figures.rms_before = result.before.normalised;
  figures.rms_after = result.after.normalised;
  figures.reprojection_before_px = result.before.point_px;
  figures.reprojection_after_px = result.after.point_px;
  MoveKeyframes(window, result, map);
  // A zero covariance marks a landmark without inliers: it keeps its position and covariance.
  for (size_t i = 0; i < window.points.size(); ++i) {
    if (result.point_covariances[i].isZero(0.0)) continue;
    map.SetPosition(window.points[i], result.points[i], result.point_covariances[i]);
  }
  for (size_t i = 0; i < window.lines.size(); ++i) {
    if (result.line_p_covariances[i].isZero(0.0)) continue;
    map.SetSegment(window.lines[i], result.lines[i], result.line_p_covariances[i], result.line_q_covariances[i]);
  }
  // Before convergence residuals do not identify outliers; the next adjustment will.
  if (!result.converged) return figures;
  figures.n_outliers = DropOutliers<PointType>(window, window.points, result.point_inliers, features, map) +
                       DropOutliers<LineType>(window, window.lines, result.line_inliers, features, map);
  return figures;
}

}  // namespace plslam::mapping
