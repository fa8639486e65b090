#include "mapping_process/pose_refinement.h"

#include "core/motion/motion_estimator.h"

namespace plslam {
namespace {

Eigen::Matrix3d Rotate(const Eigen::Matrix3d& R, const Eigen::Matrix3d& covariance) {
  return R * covariance * R.transpose();
}

// Observations of the landmarks relative to where the keyframe should be, and the features they belong to.
struct Observed {
  std::vector<PointObservation> points;
  std::vector<LineObservation> lines;
  std::vector<size_t> point_features;
  std::vector<size_t> line_features;
};

void ObservePoints(const Map& map, const std::vector<StereoPoint>& features, const SE3& T_ref_w,
                   const std::vector<int64_t>& association, Observed& observed) {
  const Eigen::Matrix3d R = T_ref_w.R();
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const MapPoint& point = *map.FindPoint(association[i]);
    const StereoPoint& seen = features[i];
    observed.points.push_back({T_ref_w * point.p_w,
                               Rotate(R, point.covariance),
                               {seen.left.px.x(), seen.left.px.y(), seen.disparity_px},
                               seen.sigma_px,
                               seen.sigma_disparity_px});
    observed.point_features.push_back(i);
  }
}

void ObserveLines(const Map& map, const std::vector<StereoLine>& features, const SE3& T_ref_w,
                  const std::vector<int64_t>& association, Observed& observed) {
  const Eigen::Matrix3d R = T_ref_w.R();
  for (size_t i = 0; i < association.size(); ++i) {
    if (association[i] < 0) continue;
    const MapLine& line = *map.FindLine(association[i]);
    const StereoLine& seen = features[i];
    LineObservation observation{{T_ref_w * line.segment_w.p, T_ref_w * line.segment_w.q},
                                Rotate(R, line.covariance_p),
                                Rotate(R, line.covariance_q),
                                seen.left.segment};
    observation.disparity_p_px = seen.disparity_p_px;
    observation.disparity_q_px = seen.disparity_q_px;
    observation.sigma_px = seen.sigma_px;
    observation.sigma_disparity_p_px = seen.sigma_disparity_p_px;
    observation.sigma_disparity_q_px = seen.sigma_disparity_q_px;
    observed.lines.push_back(observation);
    observed.line_features.push_back(i);
  }
}

}  // namespace

std::optional<KeyframePose> RefinePose(const Map& map, const StereoFeatures& features, const StereoCamera& camera,
                                       const SE3& T_w_kf, const MotionOptions& options, Association& association) {
  Observed observed;
  const SE3 T_ref_w = T_w_kf.Inverse();
  ObservePoints(map, features.points, T_ref_w, association.points, observed);
  ObserveLines(map, features.lines, T_ref_w, association.lines, observed);
  const auto estimate = EstimateMotion(observed.points, observed.lines, camera, SE3(), std::nullopt, options);
  if (!estimate) return std::nullopt;
  for (size_t i = 0; i < observed.points.size(); ++i) {
    if (!estimate->point_inliers[i]) association.points[observed.point_features[i]] = -1;
  }
  for (size_t i = 0; i < observed.lines.size(); ++i) {
    if (!estimate->line_inliers[i]) association.lines[observed.line_features[i]] = -1;
  }
  return KeyframePose{T_w_kf * estimate->T_cur_ref.Inverse(), estimate->covariance};
}

}  // namespace plslam
