// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/line_landmarks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "core/features/matching/hamming.h"
#include "core/features/matching/line_matcher.h"
#include "core/features/matching/segment_projection.h"
#include "core/geometry/hypot.h"
#include "core/geometry/triangulation.h"
#include "core/localisation/pose_refinement.h"
#include "vo_process/tracking/landmarks/landmark_list.h"

namespace plslam::vo {
namespace {

// Largest extension of a segment by one observation, in lengths of it.
constexpr double kMaxExtension = 0.5;

Segment3 Transform(const SE3& T, const Segment3& segment) { return {T * segment.p, T * segment.q}; }

Eigen::Vector3d Measurement(const Eigen::Vector2d& px, double disparity_px) { return {px.x(), px.y(), disparity_px}; }

std::optional<Segment2> Predict(const SE3& T_c_odom, const LineLandmark& landmark, const StereoCamera& camera,
                                double margin_px) {
  return ProjectSegment(Transform(T_c_odom, landmark.segment_odom), camera, margin_px);
}

// Measurements of one endpoint: distances from the observed lines in the left and, with depth, the right image.
struct EndpointMeasurements {
  std::array<LinearMeasurement, 2> values;
  int count = 0;
};

EndpointMeasurements MeasureEndpoint(const Eigen::Vector3d& p_c, const Eigen::Matrix3d& R_c_odom,
                                     const StereoLine& seen, const StereoCamera& camera) {
  EndpointMeasurements result;
  const Eigen::Vector3d uvd = camera.ProjectStereo(p_c);
  const Eigen::Matrix3d J = camera.ProjectStereoJacobian(p_c) * R_c_odom;
  const Eigen::Vector3d left = LineThrough(seen.left.segment);
  const double variance = VarianceAcross(seen.left.segment, uvd.head<2>(), seen.sigma_px);
  result.values[result.count++] = {left.head<2>().transpose() * J.topRows<2>(),
                                   -left.dot(uvd.head<2>().homogeneous()), variance};
  if (!seen.HasDepth()) return result;
  const Segment2 right_segment = RightSegment(seen);
  const Eigen::Vector3d right = LineThrough(right_segment);
  const Eigen::Vector2d px(uvd.x() - uvd.z(), uvd.y());
  Eigen::Matrix<double, 2, 3> J_right = J.topRows<2>();
  J_right.row(0) -= J.row(2);
  const double sigma_disparity = std::max(seen.sigma_disparity_p_px, seen.sigma_disparity_q_px);
  const double sigma = Hypot(seen.sigma_px, right.x() * sigma_disparity);
  result.values[result.count++] = {right.head<2>().transpose() * J_right, -right.dot(px.homogeneous()),
                                   VarianceAcross(right_segment, px, sigma)};
  return result;
}

// Inflates the covariance across the segment by `growth`, so that the landmark can follow changes. Along the segment
// nothing is measured: if inflated there, an endpoint would slide with every change of the viewing angle.
void FuseEndpoint(const SE3& T_c_odom, const StereoLine& seen, const StereoCamera& camera,
                  const Eigen::Matrix3d& across, double growth, Eigen::Vector3d& p_odom,
                  Eigen::Matrix3d& covariance) {
  const Eigen::Vector3d p_c = T_c_odom * p_odom;
  if (p_c.z() < camera.MinDepth()) return;
  const EndpointMeasurements measured = MeasureEndpoint(p_c, T_c_odom.R(), seen, camera);
  covariance += growth * across * covariance * across;
  FuseMeasurements(std::span(measured.values).first(measured.count), p_odom, covariance);
}

// Moves endpoints outwards to the ends of the detected segment, with the covariance of that position on the line.
void Extend(const SE3& T_c_odom, const StereoLine& seen, const StereoCamera& camera, LineLandmark& landmark) {
  const Segment3 old = landmark.segment_odom;
  const Segment3 in_camera = Transform(T_c_odom, old);
  const auto s_p = AlongLine(in_camera, seen.left.segment.p, camera);
  const auto s_q = AlongLine(in_camera, seen.left.segment.q, camera);
  if (!s_p || !s_q || *s_p >= *s_q) return;
  const double from = std::clamp(*s_p, -kMaxExtension, 0.0);
  const double to = std::clamp(*s_q, 1.0, 1.0 + kMaxExtension);
  const auto covariance_at = [cov_p = landmark.covariance_p, cov_q = landmark.covariance_q](double s) {
    return Eigen::Matrix3d((1.0 - s) * (1.0 - s) * cov_p + s * s * cov_q);
  };
  const Eigen::Vector3d along = old.q - old.p;
  if (from < 0.0) {
    landmark.segment_odom.p = old.p + from * along;
    landmark.covariance_p = covariance_at(from);
  }
  if (to > 1.0) {
    landmark.segment_odom.q = old.p + to * along;
    landmark.covariance_q = covariance_at(to);
  }
}

}  // namespace

std::vector<LandmarkMatch> LineLandmarks::MatchByProjection(const SE3& T_c_odom, const TrackedFrame& frame,
                                                            const Search& search,
                                                            const LineMatchOptions& options) const {
  std::vector<PredictedLine> predicted;
  std::vector<int> owners;
  for (int i = 0; i < static_cast<int>(landmarks_.size()); ++i) {
    if (landmarks_[i].unseen_frames > search.max_unseen_frames) continue;
    const auto segment = Predict(T_c_odom, landmarks_[i], camera_, search.radius_px);
    if (!segment) continue;
    predicted.push_back({*segment, landmarks_[i].descriptor});
    owners.push_back(i);
  }
  LineMatchOptions window = options;
  window.max_across_px = search.radius_px;
  return PairUp(owners, MatchLinesByProjection(predicted, frame.features.lines, window));
}

std::vector<LandmarkMatch> LineLandmarks::MatchByDescriptor(const TrackedFrame& frame, int max_unseen_frames,
                                                            const LineMatchOptions& options) const {
  const KnownDescriptors known = RecentDescriptors(landmarks_, max_unseen_frames);
  return PairUp(known.owners, MatchLinesBruteForce(known.descriptors, DescriptorsOf(frame.features.lines), options));
}

std::vector<LineCorrespondence> LineLandmarks::Observations(const std::vector<LandmarkMatch>& matches,
                                                            const TrackedFrame& frame) const {
  std::vector<LineCorrespondence> observations;
  observations.reserve(matches.size());
  for (const LandmarkMatch& match : matches) {
    const LineLandmark& landmark = landmarks_[match.landmark];
    observations.push_back(ObservationOf(landmark.segment_odom, landmark.covariance_p, landmark.covariance_q,
                                         frame.features.lines[match.feature]));
  }
  return observations;
}

void LineLandmarks::Update(const SE3& T_odom_c, const std::vector<LandmarkMatch>& matches, TrackedFrame& frame) {
  for (LineLandmark& landmark : landmarks_) ++landmark.unseen_frames;
  for (const LandmarkMatch& match : matches) {
    LineLandmark& landmark = landmarks_[match.landmark];
    Fuse(T_odom_c, frame.features.lines[match.feature], landmark);
    frame.line_tracks[match.feature] = {landmark.id, landmark.seen, landmark.map_id, landmark.map_observations};
    ++landmark.seen;
    landmark.unseen_frames = 0;
    landmark.missed = 0;
  }
  if (!frame.is_followed) Age(T_odom_c.Inverse());
}

void LineLandmarks::Fuse(const SE3& T_odom_c, const StereoLine& seen, LineLandmark& landmark) const {
  const SE3 T_c_odom = T_odom_c.Inverse();
  Segment3& segment = landmark.segment_odom;
  const Eigen::Vector3d along = (segment.q - segment.p).normalized();
  const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - along * along.transpose();
  const double growth = options_.forgetting - 1.0;
  FuseEndpoint(T_c_odom, seen, camera_, across, growth, segment.p, landmark.covariance_p);
  FuseEndpoint(T_c_odom, seen, camera_, across, growth, segment.q, landmark.covariance_q);
  if (seen.HasDepth()) Extend(T_c_odom, seen, camera_, landmark);
  landmark.descriptor = seen.left.descriptor;
}

void LineLandmarks::Age(const SE3& T_c_odom) {
  for (LineLandmark& landmark : landmarks_) {
    if (landmark.unseen_frames > 0 && Predict(T_c_odom, landmark, camera_, 0.0)) ++landmark.missed;
  }
  DropStale(options_, landmarks_);
}

void LineLandmarks::Adopt(const SE3& T_odom_w, const std::vector<Adopted<MapLine>>& adopted, TrackId& next_id) {
  const Eigen::Matrix3d R = T_odom_w.R();
  AdoptEach(adopted, next_id, landmarks_, [&](const MapLine& known, bool is_new, LineLandmark& landmark) {
    landmark.segment_odom = Transform(T_odom_w, known.segment_w);
    landmark.covariance_p = RotateCovariance(R, known.covariance_p);
    landmark.covariance_q = RotateCovariance(R, known.covariance_q);
    if (is_new) landmark.descriptor = known.descriptor;
  });
}

void LineLandmarks::Move(const SE3& T_new_odom) {
  const Eigen::Matrix3d R = T_new_odom.R();
  for (LineLandmark& landmark : landmarks_) {
    landmark.segment_odom = Transform(T_new_odom, landmark.segment_odom);
    landmark.covariance_p = RotateCovariance(R, landmark.covariance_p);
    landmark.covariance_q = RotateCovariance(R, landmark.covariance_q);
  }
}

LineLandmarks LineLandmarks::Take(const std::vector<char>& taken) {
  LineLandmarks taken_out(camera_, options_);
  taken_out.landmarks_ = TakeFlagged(taken, landmarks_);
  return taken_out;
}

LineLandmarks LineLandmarks::Copy(const std::vector<char>& chosen) const {
  LineLandmarks copied(camera_, options_);
  copied.landmarks_ = CopyFlagged(chosen, landmarks_);
  return copied;
}

void LineLandmarks::Append(const LineLandmarks& others) {
  landmarks_.insert(landmarks_.end(), others.landmarks_.begin(), others.landmarks_.end());
}

void LineLandmarks::Create(const SE3& T_odom_c, TrackedFrame& frame, TrackId& next_id, int body) {
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    FeatureTrack& track = frame.line_tracks[i];
    if (track.landmark_id < 0 && track.body == body) CreateOne(T_odom_c, frame.features.lines[i], track, next_id);
  }
}

void LineLandmarks::Initialise(const SE3& T_odom_c, TrackedFrame& frame, TrackId& next_id) {
  landmarks_.clear();
  for (size_t i = 0; i < frame.features.lines.size(); ++i) {
    FeatureTrack& track = frame.line_tracks[i];
    if (track.IsOfWorld()) CreateOne(T_odom_c, frame.features.lines[i], track, next_id);
  }
}

void LineLandmarks::CreateOne(const SE3& T_odom_c, const StereoLine& seen, FeatureTrack& track, TrackId& next_id) {
  if (!seen.HasDepth()) return;
  const double limit = options_.max_relative_depth_sigma;
  if (seen.sigma_disparity_p_px > limit * seen.disparity_p_px) return;
  if (seen.sigma_disparity_q_px > limit * seen.disparity_q_px) return;
  if (track.landmark_id < 0) track.landmark_id = next_id++;
  const Eigen::Vector3d p = Measurement(seen.left.segment.p, seen.disparity_p_px);
  const Eigen::Vector3d q = Measurement(seen.left.segment.q, seen.disparity_q_px);
  const Eigen::Matrix3d R = T_odom_c.R();
  LineLandmark landmark;
  landmark.id = track.landmark_id;
  landmark.seen = track.age + 1;
  landmark.map_id = track.map_id;
  landmark.segment_odom = {T_odom_c * camera_.Backproject(p), T_odom_c * camera_.Backproject(q)};
  landmark.covariance_p =
      R * camera_.BackprojectCovariance(p, seen.sigma_px, seen.sigma_disparity_p_px) * R.transpose();
  landmark.covariance_q =
      R * camera_.BackprojectCovariance(q, seen.sigma_px, seen.sigma_disparity_q_px) * R.transpose();
  landmark.descriptor = seen.left.descriptor;
  landmarks_.push_back(landmark);
}

}  // namespace plslam::vo
