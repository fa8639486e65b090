#include "mapping_process/insertion/local_window.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include "core/geometry/rotate_covariance.h"
#include "core/localisation/landmark_kinds.h"
#include "core/localisation/local_map.h"
#include "core/optim/bundle/bundle_sights.h"
#include "mapping_process/insertion/sights.h"

namespace plslam {
namespace {

// Errors at which the map contradicts a motion by the tracker: it was lost meanwhile. Squared, in deviations; and metres or
// radians, since deviations of a standing camera are tiny.
constexpr double kContradicted2 = 900.0;
constexpr double kContradicted = 0.1;
// Deviation from which nothing is known of a pose.
constexpr double kUnknown_m = 100.0;
// Keyframes at the beginning of a session whose surroundings are adjusted more widely where another session has been, and how
// much more widely.
constexpr int64_t kSeamKeyframes = 10;
constexpr int kSeamFactor = 2;

bool IsContradicted(const SE3& error, const Matrix6d& covariance) {
  const Vector6d e = error.Log();
  return e.norm() > kContradicted && e.dot(covariance.ldlt().solve(e)) > kContradicted2;
}

// Whether a session begins here among keyframes of another one: no motion ties it to them, landmarks alone do.
bool IsSeam(std::span<const int64_t> keyframes, const Map& map) {
  const MapKeyframe& newest = *map.FindKeyframe(keyframes.front());
  return newest.session_keyframe_id < kSeamKeyframes &&
         std::any_of(keyframes.begin(), keyframes.end(),
                     [&](int64_t id) { return map.FindKeyframe(id)->session != newest.session; });
}

// Landmarks that at least two keyframes see, one of them free; where they, or the sights of them that a window of this size
// may hold, are too many, those that most see.
template <class Kind>
std::vector<int64_t> SeenTwice(const std::vector<int64_t>& free, const Map& map, size_t window_size, int max_count,
                               int max_sights) {
  std::vector<std::pair<size_t, int64_t>> ranked;
  for (const int64_t id : SeenBy<Kind>(free, map)) {
    const size_t n_sights = Kind::Find(map, id)->sights.size();
    if (n_sights >= 2) ranked.emplace_back(n_sights, id);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<int64_t> chosen;
  size_t total = 0;
  for (const auto& [n_sights, id] : ranked) {
    total += std::min(n_sights, window_size);
    if (chosen.size() >= static_cast<size_t>(max_count) || total > static_cast<size_t>(max_sights)) break;
    chosen.push_back(id);
  }
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

std::vector<int64_t> FixedKeyframes(const LocalWindow& window, const Map& map, int max_count) {
  std::map<int64_t, int> counts;
  CountKeyframes<PointKind>(window.points, map, counts);
  CountKeyframes<LineKind>(window.lines, map, counts);
  for (const int64_t id : window.keyframes) counts.erase(id);
  return MostCounted(counts, max_count);
}

// Calls visit(pose, landmark, sight) for each sight of the landmarks by a keyframe of the window, always in one order.
template <class Kind, class Visit>
void ForEachSight(const std::vector<int64_t>& keyframes, const std::vector<int64_t>& ids, const Map& map,
                  const Visit& visit) {
  std::map<int64_t, int> poses;
  for (int i = 0; i < static_cast<int>(keyframes.size()); ++i) poses[keyframes[static_cast<size_t>(i)]] = i;
  for (int k = 0; k < static_cast<int>(ids.size()); ++k) {
    for (const Sight& sight : Kind::Find(map, ids[static_cast<size_t>(k)])->sights) {
      const auto pose = poses.find(sight.keyframe_id);
      if (pose != poses.end()) visit(pose->second, k, sight);
    }
  }
}

void AddPoses(size_t n_free, const Map& map, LocalWindow& window) {
  const int64_t first = map.keyframes().begin()->first;
  for (size_t i = 0; i < window.keyframes.size(); ++i) {
    const int64_t id = window.keyframes[i];
    window.problem.poses.push_back({map.FindKeyframe(id)->T_w_kf, i >= n_free || id == first});
  }
  // Where nothing holds the window in place, its oldest keyframe does.
  const auto fixed = [](const BundlePose& pose) { return pose.fixed; };
  if (std::none_of(window.problem.poses.begin(), window.problem.poses.end(), fixed)) {
    const auto oldest = std::min_element(window.keyframes.begin(), window.keyframes.end());
    window.problem.poses[static_cast<size_t>(oldest - window.keyframes.begin())].fixed = true;
  }
}

// What tracking says of the motion from keyframe to keyframe: it has seen the frames between.
void AddRelativePoses(const Map& map, double relative_sigma, LocalWindow& window) {
  std::map<int64_t, int> places;
  for (int i = 0; i < static_cast<int>(window.keyframes.size()); ++i)
    places[window.keyframes[static_cast<size_t>(i)]] = i;
  for (const auto& [id, place] : places) {
    const MapKeyframe& keyframe = *map.FindKeyframe(id);
    const auto previous = places.find(keyframe.previous_id);
    if (previous == places.end()) continue;
    const Matrix6d covariance = relative_sigma * relative_sigma * keyframe.relative_covariance;
    const SE3 T_prevkf_kf = map.FindKeyframe(previous->first)->T_w_kf.Inverse() * keyframe.T_w_kf;
    if (IsContradicted(keyframe.T_prevkf_kf.Inverse() * T_prevkf_kf, covariance)) continue;
    window.problem.relative_poses.push_back({previous->second, place, keyframe.T_prevkf_kf, covariance});
  }
}

void AddLandmarks(const Map& map, const KeyframeFeatures& features, LocalWindow& window) {
  BundleProblem& problem = window.problem;
  for (const int64_t id : window.points) problem.points.push_back({map.FindPoint(id)->p_w});
  for (const int64_t id : window.lines) problem.lines.push_back({map.FindLine(id)->segment_w});
  ForEachSight<PointKind>(window.keyframes, window.points, map, [&](int pose, int point, const Sight& sight) {
    const auto& list = features.at(sight.keyframe_id).points;
    problem.point_sights.push_back(SightOf(pose, point, list[static_cast<size_t>(sight.feature)]));
  });
  ForEachSight<LineKind>(window.keyframes, window.lines, map, [&](int pose, int line, const Sight& sight) {
    const auto& list = features.at(sight.keyframe_id).lines;
    problem.line_sights.push_back(SightOf(pose, line, list[static_cast<size_t>(sight.feature)]));
  });
}

// Whether a landmark that is not adjusted goes with this keyframe: the newest that sees it.
template <class Landmark>
bool GoesWith(const Landmark& landmark, int64_t keyframe_id, const std::vector<int64_t>& adjusted) {
  return landmark.sights.back().keyframe_id == keyframe_id &&
         !std::binary_search(adjusted.begin(), adjusted.end(), landmark.id);
}

// What is not adjusted itself keeps its place relative to its keyframe.
void MoveOthers(int64_t keyframe_id, const SE3& T_new_old, const LocalWindow& window, Map& map) {
  const Eigen::Matrix3d R = T_new_old.R();
  for (const int64_t id : PointKind::Of(map, keyframe_id)) {
    if (id < 0 || !GoesWith(*map.FindPoint(id), keyframe_id, window.points)) continue;
    const MapPoint& point = *map.FindPoint(id);
    map.SetPosition(id, T_new_old * point.p_w, RotateCovariance(R, point.covariance));
  }
  for (const int64_t id : LineKind::Of(map, keyframe_id)) {
    if (id < 0 || !GoesWith(*map.FindLine(id), keyframe_id, window.lines)) continue;
    const MapLine& line = *map.FindLine(id);
    map.SetSegment(id, {T_new_old * line.segment_w.p, T_new_old * line.segment_w.q},
                   RotateCovariance(R, line.covariance_p), RotateCovariance(R, line.covariance_q));
  }
}

template <class Kind>
int DropOutliers(const LocalWindow& window, const std::vector<int64_t>& ids, const std::vector<bool>& inliers,
                 const KeyframeFeatures& features, Map& map) {
  std::vector<std::pair<int64_t, int64_t>> outliers;
  size_t i = 0;
  ForEachSight<Kind>(window.keyframes, ids, map, [&](int, int landmark, const Sight& sight) {
    if (!inliers[i++]) outliers.emplace_back(ids[static_cast<size_t>(landmark)], sight.keyframe_id);
  });
  for (const auto& [landmark_id, keyframe_id] : outliers) DropSight<Kind>(landmark_id, keyframe_id, features, map);
  return static_cast<int>(outliers.size());
}

// What an adjustment says of a pose of which nobody saw anything (`BundleResult`): next to nothing.
bool IsUnknown(const Matrix6d& covariance) { return covariance.trace() > kUnknown_m * kUnknown_m; }

// Covariances of the adjustment are relative to what was fixed; that has one of its own. A keyframe that took part by its motion
// alone keeps what it had.
void MoveKeyframes(const LocalWindow& window, const BundleResult& result, Map& map) {
  const auto& poses = window.problem.poses;
  const auto fixed = std::find_if(poses.begin(), poses.end(), [](const BundlePose& pose) { return pose.fixed; });
  const MapKeyframe anchor = *map.FindKeyframe(window.keyframes[static_cast<size_t>(fixed - poses.begin())]);
  for (size_t i = 0; i < window.keyframes.size(); ++i) {
    if (window.problem.poses[i].fixed) continue;
    const int64_t id = window.keyframes[i];
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

LocalWindow MakeLocalWindow(int64_t keyframe_id, const Map& map, const KeyframeFeatures& features,
                            const StereoCamera& camera, const WindowOptions& options) {
  LocalWindow window;
  window.problem.camera = camera;
  window.keyframes = KeyframesAround(keyframe_id, map, options.min_shared, kSeamFactor * options.keyframes);
  const size_t usual = std::min(window.keyframes.size(), static_cast<size_t>(options.keyframes));
  const bool at_seam = IsSeam({window.keyframes.data(), usual}, map);
  if (!at_seam) window.keyframes.resize(usual);
  const size_t n_free = window.keyframes.size();
  const int factor = at_seam ? kSeamFactor : 1;
  const int n_fixed = factor * options.fixed_keyframes;
  const size_t size = n_free + static_cast<size_t>(n_fixed);
  window.points =
      SeenTwice<PointKind>(window.keyframes, map, size, options.max_points, factor * options.max_point_sights);
  window.lines =
      SeenTwice<LineKind>(window.keyframes, map, size, options.max_lines, factor * options.max_line_sights);
  const std::vector<int64_t> fixed = FixedKeyframes(window, map, n_fixed);
  window.keyframes.insert(window.keyframes.end(), fixed.begin(), fixed.end());
  AddPoses(n_free, map, window);
  AddLandmarks(map, features, window);
  AddRelativePoses(map, options.relative_sigma, window);
  return window;
}

LocalWindow MakeLandmarkWindow(const Map& map, const KeyframeFeatures& features, const StereoCamera& camera) {
  LocalWindow window;
  window.problem.camera = camera;
  for (const auto& [id, keyframe] : map.keyframes()) {
    window.keyframes.push_back(id);
    window.problem.poses.push_back({keyframe.T_w_kf, true});
  }
  for (const auto& [id, point] : map.points()) {
    if (point.sights.size() >= 2) window.points.push_back(id);
  }
  for (const auto& [id, line] : map.lines()) {
    if (line.sights.size() >= 2) window.lines.push_back(id);
  }
  AddLandmarks(map, features, window);
  return window;
}

AdjustmentFigures ApplyAdjustment(const LocalWindow& window, const BundleResult& result,
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
  // Zero says that no sight agreed: those stay as they were, with the uncertainty they had.
  for (size_t i = 0; i < window.points.size(); ++i) {
    if (result.point_covariances[i].isZero(0.0)) continue;
    map.SetPosition(window.points[i], result.points[i], result.point_covariances[i]);
  }
  for (size_t i = 0; i < window.lines.size(); ++i) {
    if (result.line_p_covariances[i].isZero(0.0)) continue;
    map.SetSegment(window.lines[i], result.lines[i], result.line_p_covariances[i], result.line_q_covariances[i]);
  }
  // Poses that were on their way tell no outliers; the next adjustment looks again.
  if (!result.settled) return figures;
  figures.n_outliers = DropOutliers<PointKind>(window, window.points, result.point_inliers, features, map) +
                       DropOutliers<LineKind>(window, window.lines, result.line_inliers, features, map);
  return figures;
}

}  // namespace plslam
