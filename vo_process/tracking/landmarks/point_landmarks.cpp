// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/point_landmarks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "core/features/matching/hamming.h"
#include "core/features/matching/segment_projection.h"
#include "core/geometry/triangulation.h"
#include "core/localisation/pose_refinement.h"
#include "vo_process/tracking/landmarks/landmark_list.h"

namespace plslam::vo {
namespace {

constexpr double kImageMargin_px = 4.0;

Eigen::Vector3d Measurement(const StereoPoint& point) {
  return {point.left.px.x(), point.left.px.y(), point.disparity_px};
}

void Remember(const StereoPoint& seen, double depth_m, PointLandmark& landmark) {
  landmark.descriptor = seen.left.descriptor;
  landmark.angle_rad = seen.left.angle_rad;
  landmark.octave = seen.left.octave;
  landmark.depth_m = depth_m;
}

}  // namespace

std::vector<LandmarkMatch> PointLandmarks::MatchByProjection(const SE3& T_c_odom, const TrackedFrame& frame,
                                                             const Search& search,
                                                             const MatchOptions& options) const {
  std::vector<PointQuery> queries;
  std::vector<int> owners;
  for (int i = 0; i < static_cast<int>(landmarks_.size()); ++i) {
    const PointLandmark& landmark = landmarks_[i];
    if (landmark.unseen_frames > search.max_unseen_frames) continue;
    const Eigen::Vector3d p_c = T_c_odom * landmark.p_odom;
    if (p_c.z() < camera_.MinDepth()) continue;
    const Eigen::Vector2d px = camera_.Project(p_c);
    if (!camera_.InImage(px, -search.radius_px)) continue;
    queries.push_back({px, search.radius_px,
                       ExpectedOctave(landmark.octave, landmark.depth_m, p_c.z(), orb_.scale_factor, orb_.levels),
                       landmark.angle_rad, landmark.descriptor});
    owners.push_back(i);
  }
  return PairUp(owners, MatchPointsByProjection(queries, frame.point_grid, options));
}

std::vector<LandmarkMatch> PointLandmarks::MatchByDescriptor(const TrackedFrame& frame, int max_unseen_frames,
                                                             const MatchOptions& options) const {
  const KnownDescriptors known = RecentDescriptors(landmarks_, max_unseen_frames);
  const std::vector<CornerPlace> corners = CornerPlacesOf(frame.features.points);
  return PairUp(known.owners,
                MatchBruteForce(known.descriptors, DescriptorsOf(frame.features.points), options, corners));
}

std::vector<PointCorrespondence> PointLandmarks::Observations(const std::vector<LandmarkMatch>& matches,
                                                              const TrackedFrame& frame) const {
  std::vector<PointCorrespondence> observations;
  observations.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    const PointLandmark& landmark = landmarks_[match.landmark];
    observations.push_back(ObservationOf(landmark.p_odom, landmark.covariance, frame.features.points[match.feature]));
  }
  return observations;
}

void PointLandmarks::Update(const SE3& T_odom_c, const std::vector<LandmarkMatch>& matches, TrackedFrame& frame) {
  for (PointLandmark& landmark : landmarks_) ++landmark.unseen_frames;
  for (const LandmarkMatch& match : matches) {
    PointLandmark& landmark = landmarks_[match.landmark];
    Fuse(T_odom_c, frame.features.points[match.feature], landmark);
    frame.point_tracks[match.feature] = {landmark.id, landmark.seen, landmark.map_id, landmark.map_observations};
    ++landmark.seen;
    landmark.unseen_frames = 0;
    landmark.missed = 0;
  }
  if (!frame.is_followed) Age(T_odom_c.Inverse());
}

void PointLandmarks::Fuse(const SE3& T_odom_c, const StereoPoint& seen, PointLandmark& landmark) const {
  const Eigen::Matrix3d R_c_odom = T_odom_c.R().transpose();
  const Eigen::Vector3d p_c = R_c_odom * (landmark.p_odom - T_odom_c.translation());
  if (p_c.z() < camera_.MinDepth()) return;
  const Eigen::Vector3d residual = Measurement(seen) - camera_.ProjectStereo(p_c);
  const Eigen::Matrix3d J = camera_.ProjectStereoJacobian(p_c) * R_c_odom;
  const double variance = seen.sigma_px * seen.sigma_px;
  const std::array<LinearMeasurement, 3> measurements{
      {{J.row(0), residual.x(), variance},
       {J.row(1), residual.y(), variance},
       {J.row(2), residual.z(), seen.sigma_disparity_px * seen.sigma_disparity_px}}};
  const std::span<const LinearMeasurement> all(measurements);
  // Inflates the covariance, so that the landmark can follow changes.
  landmark.covariance *= options_.forgetting;
  FuseMeasurements(seen.HasDepth() ? all : all.first(2), landmark.p_odom, landmark.covariance);
  Remember(seen, p_c.z(), landmark);
}

void PointLandmarks::Age(const SE3& T_c_odom) {
  for (PointLandmark& landmark : landmarks_) {
    if (landmark.unseen_frames == 0) continue;
    const Eigen::Vector3d p_c = T_c_odom * landmark.p_odom;
    const bool in_view = p_c.z() > camera_.MinDepth() && camera_.InImage(camera_.Project(p_c), kImageMargin_px);
    if (in_view) ++landmark.missed;
  }
  DropStale(options_, landmarks_);
}

void PointLandmarks::Adopt(const SE3& T_odom_w, const std::vector<Adopted<MapPoint>>& adopted, double map_f_px,
                           TrackId& next_id) {
  // Scales the distance so that both cameras see the octave at the same size.
  const double nearer = map_f_px > 0.0 ? camera_.f_px / map_f_px : 1.0;
  const Eigen::Matrix3d R = T_odom_w.R();
  AdoptEach(adopted, next_id, landmarks_, [&](const MapPoint& known, bool is_new, PointLandmark& landmark) {
    landmark.p_odom = T_odom_w * known.p_w;
    landmark.covariance = RotateCovariance(R, known.covariance);
    if (!is_new) return;
    landmark.descriptor = known.descriptor;
    landmark.angle_rad = known.angle_rad;
    landmark.octave = known.octave;
    landmark.depth_m = nearer * known.depth_m;
  });
}

void PointLandmarks::Move(const SE3& T_new_odom) {
  const Eigen::Matrix3d R = T_new_odom.R();
  for (PointLandmark& landmark : landmarks_) {
    landmark.p_odom = T_new_odom * landmark.p_odom;
    landmark.covariance = RotateCovariance(R, landmark.covariance);
  }
}

PointLandmarks PointLandmarks::Take(const std::vector<char>& taken) {
  PointLandmarks taken_out(camera_, orb_, options_);
  taken_out.landmarks_ = TakeFlagged(taken, landmarks_);
  return taken_out;
}

PointLandmarks PointLandmarks::Copy(const std::vector<char>& chosen) const {
  PointLandmarks copied(camera_, orb_, options_);
  copied.landmarks_ = CopyFlagged(chosen, landmarks_);
  return copied;
}

void PointLandmarks::Append(const PointLandmarks& others) {
  landmarks_.insert(landmarks_.end(), others.landmarks_.begin(), others.landmarks_.end());
}

void PointLandmarks::Create(const SE3& T_odom_c, TrackedFrame& frame, TrackId& next_id, int body) {
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    FeatureTrack& track = frame.point_tracks[i];
    if (track.landmark_id < 0 && track.body == body) CreateOne(T_odom_c, frame.features.points[i], track, next_id);
  }
}

void PointLandmarks::Initialise(const SE3& T_odom_c, TrackedFrame& frame, TrackId& next_id) {
  landmarks_.clear();
  for (size_t i = 0; i < frame.features.points.size(); ++i) {
    FeatureTrack& track = frame.point_tracks[i];
    if (track.IsOfWorld()) CreateOne(T_odom_c, frame.features.points[i], track, next_id);
  }
}

void PointLandmarks::CreateOne(const SE3& T_odom_c, const StereoPoint& seen, FeatureTrack& track, TrackId& next_id) {
  if (!seen.HasDepth() || seen.sigma_disparity_px > options_.max_relative_depth_sigma * seen.disparity_px) return;
  const Eigen::Vector3d uvd = Measurement(seen);
  const Eigen::Vector3d p_c = camera_.Backproject(uvd);
  const Eigen::Matrix3d R = T_odom_c.R();
  if (track.landmark_id < 0) track.landmark_id = next_id++;
  PointLandmark landmark;
  landmark.id = track.landmark_id;
  landmark.seen = track.age + 1;
  landmark.map_id = track.map_id;
  landmark.p_odom = T_odom_c * p_c;
  landmark.covariance =
      R * camera_.BackprojectCovariance(uvd, seen.sigma_px, seen.sigma_disparity_px) * R.transpose();
  Remember(seen, p_c.z(), landmark);
  landmarks_.push_back(landmark);
}

}  // namespace plslam::vo
