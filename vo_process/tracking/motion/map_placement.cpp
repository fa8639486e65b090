// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/motion/map_placement.h"

#include <algorithm>
#include <vector>

#include "core/motion/motion_estimator.h"
#include "vo_process/tracking/landmarks/landmark_list.h"

namespace plslam::vo {
namespace {

// Least standard deviation of a difference between two positions of a landmark in the image.
constexpr double kSigma_px = 0.1;

/// Calls `use(known, own)` for each landmark of the map that the last frame has shown as one of the tracker's.
template <class Known, class Landmark, class Use>
void ForEachShown(const std::vector<Adopted<Known>>& adopted, const std::vector<Landmark>& landmarks,
                  const Use& use) {
  const IdIndex<TrackId, size_t> by_id = IndicesBy(&Landmark::id, landmarks);
  const IdIndex<LandmarkId, size_t> by_map_id = IndicesBy(&Landmark::map_id, landmarks);
  for (const Adopted<Known>& entry : adopted) {
    const Landmark* own = nullptr;
    const auto consider = [&](auto found) {
      for (const auto& [id, place] : found) {
        if (own == nullptr && landmarks[place].unseen_frames == 0) own = &landmarks[place];
      }
    };
    consider(by_map_id.Find(entry.landmark->id));
    for (const TrackId id : entry.tracker_ids) consider(by_id.Find(id));
    if (own != nullptr) use(*entry.landmark, *own);
  }
}

}  // namespace

std::optional<SE3> PlacementInMap(const LocalLandmarks& landmarks, const TrackerLocalMap& local_map,
                                  const SE3& T_odom_c, const StereoCamera& camera, const MotionOptions& motion,
                                  int min_weight) {
  const SE3 T_c_odom = T_odom_c.Inverse();
  const Eigen::Matrix3d R_w_odom = local_map.T_w_odom.R();
  // Both positions of a landmark are uncertain, above all along the ray.
  const auto both = [&](const LandmarkCovariance& known, const Eigen::Matrix3d& own) {
    return Eigen::Matrix3d(Eigen::Matrix3d(known) + RotateCovariance(R_w_odom, own));
  };
  std::vector<PointCorrespondence> points;
  ForEachShown(local_map.points, landmarks.points.landmarks(), [&](const MapPoint& known, const PointLandmark& own) {
    const Eigen::Vector3d p_c = T_c_odom * own.p_odom;
    if (p_c.z() < camera.MinDepth()) return;
    points.push_back(
        {known.p_w, both(known.covariance, own.covariance), camera.ProjectStereo(p_c), kSigma_px, kSigma_px});
  });
  std::vector<LineCorrespondence> lines;
  ForEachShown(local_map.lines, landmarks.lines.landmarks(), [&](const MapLine& known, const LineLandmark& own) {
    const Eigen::Vector3d p_c = T_c_odom * own.segment_odom.p;
    const Eigen::Vector3d q_c = T_c_odom * own.segment_odom.q;
    if (std::min(p_c.z(), q_c.z()) < camera.MinDepth()) return;
    const Eigen::Vector3d p = camera.ProjectStereo(p_c);
    const Eigen::Vector3d q = camera.ProjectStereo(q_c);
    lines.push_back({known.segment_w,
                     both(known.covariance_p, own.covariance_p),
                     both(known.covariance_q, own.covariance_q),
                     {p.head<2>(), q.head<2>()},
                     p.z(),
                     q.z(),
                     kSigma_px,
                     kSigma_px,
                     kSigma_px});
  });
  const int weight = static_cast<int>(points.size() + 2 * lines.size());
  if (weight < min_weight) return std::nullopt;
  const auto found =
      EstimateMotion(points, lines, camera, (local_map.T_w_odom * T_odom_c).Inverse(), std::nullopt, motion);
  if (!found || 2 * (found->n_point_inliers + 2 * found->n_line_inliers) < weight) return std::nullopt;
  return found->T_cur_ref.Inverse() * T_c_odom;
}

}  // namespace plslam::vo
