// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/tracking/landmarks/keyframe_measurements.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <utility>

#include "core/features/matching/segment_projection.h"
#include "core/geometry/hypot.h"

namespace plslam::vo {
namespace {

// Share of a measurement's variance common to neighbouring frames (such as the position of a corner in its patch).
constexpr double kCommonShare = 0.3;
constexpr int kMinObservations = 2;
// Least sine of the angle of right lines to the rows for which the intersection with a row gives a disparity.
constexpr double kMinTilt = 0.1;

// Number of the last keyframe's image, whose features are followed in the frames after it, among detections.
constexpr int kOfLastKeyframe = 0;

/// Returns the number of detections since the last keyframe in which a landmark was found; `seen` is in the order of the frames.
template <class Observations>
int NumDetections(const Observations& seen) {
  int n = 0, last = kOfLastKeyframe;
  for (const auto& [id, observation] : seen) n += observation.detection != std::exchange(last, observation.detection);
  return n;
}

/// Returns the number of observations of the same detection as the i-th.
template <class Observations>
int NumAlike(const Observations& seen, size_t i) {
  const auto is_earlier = [](const auto& a, const auto& b) { return a.second.detection < b.second.detection; };
  const auto [first, end] = std::equal_range(seen.begin(), seen.end(), seen[i], is_earlier);
  return static_cast<int>(end - first);
}

/// Whether a landmark that the keyframe's image does not show may be added to it. A point of one detection, moved to the
/// keyframe's pose, would confirm that pose and its own first position; followed lines are located in each frame.
template <class Feature, class Observations>
bool MayBeAdded(const Observations& seen) {
  return std::is_same_v<Feature, StereoLine> || NumDetections(seen) >= kMinObservations;
}

double ShrinkFactor(int n) { return std::sqrt(kCommonShare + (1.0 - kCommonShare) / n); }

/// Weighted mean of a scalar.
class Mean {
 public:
  void Add(double value, double variance) {
    sum_ += value / variance;
    weight_ += 1.0 / variance;
    ++n_;
  }
  int n() const { return n_; }
  double value() const { return sum_ / weight_; }

 private:
  double sum_ = 0.0;
  double weight_ = 0.0;
  int n_ = 0;
};

/// Mean distances of a segment's projected ends from the observed lines in one image.
struct EndMeans {
  Mean p;
  Mean q;

  void Add(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, const Segment2& observed, double sigma_px) {
    const Eigen::Vector3d line = LineThrough(observed);
    p.Add(line.dot(p_px.homogeneous()), VarianceAcross(observed, p_px, sigma_px));
    q.Add(line.dot(q_px.homogeneous()), VarianceAcross(observed, q_px, sigma_px));
  }

  /// Returns the segment through the mean distances from the projected ends.
  Segment2 Line(const Eigen::Vector2d& p_px, const Eigen::Vector2d& q_px, const Segment2& observed) const {
    const Eigen::Vector2d normal = LineThrough(observed).head<2>();
    return {p_px - p.value() * normal, q_px - q.value() * normal};
  }
};

/// Ends of a segment in both images.
struct ProjectedSegment {
  Eigen::Vector3d p_uvd;
  Eigen::Vector3d q_uvd;

  Segment2 Left() const { return {p_uvd.head<2>(), q_uvd.head<2>()}; }
  Segment2 Right() const { return {{p_uvd.x() - p_uvd.z(), p_uvd.y()}, {q_uvd.x() - q_uvd.z(), q_uvd.y()}}; }
};

std::optional<ProjectedSegment> Project(const SE3& T_c_odom, const Segment3& segment, const StereoCamera& camera) {
  const Eigen::Vector3d p_c = T_c_odom * segment.p;
  const Eigen::Vector3d q_c = T_c_odom * segment.q;
  if (p_c.z() < camera.MinDepth() || q_c.z() < camera.MinDepth()) return std::nullopt;
  return ProjectedSegment{camera.ProjectStereo(p_c), camera.ProjectStereo(q_c)};
}

Eigen::Vector2d OntoLine(const Eigen::Vector2d& px, const Segment2& line) {
  const Eigen::Vector2d along = (line.q - line.p).normalized();
  return line.p + along.dot(px - line.p) * along;
}

// Disparity from the intersection of a left pixel's row with the right line; nullopt if that is too flat.
std::optional<double> DisparityOn(const Eigen::Vector2d& left_px, const Segment2& right) {
  const Eigen::Vector3d line = LineThrough(right);
  if (std::abs(line.x()) < kMinTilt) return std::nullopt;
  const double u_right = -(line.y() * left_px.y() + line.z()) / line.x();
  return left_px.x() - u_right;
}

}  // namespace

void KeyframeMeasurements::Add(const SE3& T_odom_c, const TrackedFrame& frame) {
  const int before = frames_.empty() ? 0 : frames_.back().detection;
  Frame& added = frames_.emplace_back();
  added.detection = frame.is_followed ? before : before + 1;
  added.T_c_odom = T_odom_c.Inverse();
  for (size_t i = 0; i < frame.point_tracks.size(); ++i) {
    const TrackId id = frame.point_tracks[i].landmark_id;
    if (id >= 0 && frame.point_tracks[i].IsOfWorld()) added.points.push_back({id, frame.features.points[i]});
  }
  for (size_t i = 0; i < frame.line_tracks.size(); ++i) {
    const TrackId id = frame.line_tracks[i].landmark_id;
    if (id >= 0 && frame.line_tracks[i].IsOfWorld()) added.lines.push_back({id, frame.features.lines[i]});
  }
  if (frames_.size() > kMaxFrames) frames_.pop_front();
}

KeyframeContent KeyframeMeasurements::Take(const LocalLandmarks& landmarks, KeyframeContent content) {
  ImproveAll(landmarks.points.landmarks(), Collect(&Frame::points), content.features.points, content.point_tracks);
  ImproveAll(landmarks.lines.landmarks(), Collect(&Frame::lines), content.features.lines, content.line_tracks);
  frames_.clear();
  return content;
}

template <class Feature>
IdIndex<TrackId, KeyframeMeasurements::Seen<Feature>> KeyframeMeasurements::Collect(
    std::vector<Named<Feature>> Frame::*of) const {
  size_t n = 0;
  for (const Frame& frame : frames_) n += (frame.*of).size();
  std::vector<std::pair<TrackId, Seen<Feature>>> seen;
  seen.reserve(n);
  for (const Frame& frame : frames_) {
    for (const Named<Feature>& named : frame.*of) {
      seen.push_back({named.landmark_id, {&frame.T_c_odom, &named.feature, frame.detection}});
    }
  }
  return IdIndex(std::move(seen));
}

template <class Landmark, class Feature>
void KeyframeMeasurements::ImproveAll(const std::vector<Landmark>& landmarks,
                                      const IdIndex<TrackId, Seen<Feature>>& collected,
                                      std::vector<Feature>& features, std::vector<FeatureTrack>& tracks) const {
  const IdIndex<TrackId, size_t> feature_of = IndicesBy(&FeatureTrack::landmark_id, tracks);
  for (const Landmark& landmark : landmarks) {
    const Observations<Feature> seen = collected.Find(landmark.id);
    if (seen.size() < kMinObservations) continue;
    const auto found = feature_of.Find(landmark.id);
    if (!found.empty()) {
      Improve(landmark, seen, features[found.back().second]);
      continue;
    }
    if (!MayBeAdded<Feature>(seen)) continue;
    Feature feature = *seen.back().second.feature;
    if (!Expect(landmark, feature) || !Improve(landmark, seen, feature)) continue;
    features.push_back(feature);
    tracks.push_back({landmark.id, landmark.seen, landmark.map_id});
  }
}

bool KeyframeMeasurements::Improve(const PointLandmark& landmark, Observations<StereoPoint> seen,
                                   StereoPoint& feature) const {
  const auto project = [&](const SE3& T_c_odom) -> std::optional<Eigen::Vector3d> {
    const Eigen::Vector3d p_c = T_c_odom * landmark.p_odom;
    if (p_c.z() < camera_.MinDepth()) return std::nullopt;
    return camera_.ProjectStereo(p_c);
  };
  const auto here = project(frames_.back().T_c_odom);
  if (!here) return false;
  Mean u, v, d;
  const int n_detections = std::max(1, NumDetections(seen));
  for (size_t i = 0; i < seen.size(); ++i) {
    const auto& [id, observation] = seen[i];
    // The error of the last keyframe's image is in that keyframe.
    if (observation.detection == kOfLastKeyframe && seen.back().second.detection != kOfLastKeyframe) continue;
    const auto expected = project(*observation.T_c_odom);
    if (!expected) continue;
    const StereoPoint& measured = *observation.feature;
    // The errors of a point that is followed are those of its detection, which counts once.
    const double n_alike = NumAlike(seen, i);
    u.Add(measured.left.px.x() - expected->x(), n_alike * measured.sigma_px * measured.sigma_px);
    v.Add(measured.left.px.y() - expected->y(), n_alike * measured.sigma_px * measured.sigma_px);
    if (measured.HasDepth()) {
      d.Add(measured.disparity_px - expected->z(),
            n_alike * measured.sigma_disparity_px * measured.sigma_disparity_px);
    }
  }
  if (u.n() < kMinObservations) return false;
  const Eigen::Vector2d px = here->head<2>() + Eigen::Vector2d(u.value(), v.value());
  if (!camera_.InImage(px, 0.0)) return false;
  feature.left.px = px;
  feature.sigma_px *= ShrinkFactor(n_detections);
  if (!feature.HasDepth()) return true;
  feature.disparity_px = d.n() > 0 ? here->z() + d.value() : -1.0;
  feature.sigma_disparity_px *= ShrinkFactor(std::clamp(d.n(), 1, n_detections));
  return true;
}

bool KeyframeMeasurements::Improve(const LineLandmark& landmark, Observations<StereoLine> seen,
                                   StereoLine& feature) const {
  const auto here = Project(frames_.back().T_c_odom, landmark.segment_odom, camera_);
  if (!here) return false;
  EndMeans left;
  for (const auto& [id, observation] : seen) {
    const auto expected = Project(*observation.T_c_odom, landmark.segment_odom, camera_);
    if (!expected) continue;
    const Segment2 projected = expected->Left();
    left.Add(projected.p, projected.q, observation.feature->left.segment, observation.feature->sigma_px);
  }
  const Segment2 projected = here->Left();
  // A mean at ends that are close together does not determine the direction far from them.
  if (left.p.n() < kMinObservations || projected.Length() < 0.5 * feature.left.segment.Length()) return false;
  const Segment2 mean = left.Line(projected.p, projected.q, feature.left.segment);
  const Segment2 moved{OntoLine(feature.left.segment.p, mean), OntoLine(feature.left.segment.q, mean)};
  const auto visible = ClipToImage(moved, camera_, 0.0);
  if (!visible) return false;
  StereoLine improved = feature;
  improved.left.segment = *visible;
  improved.sigma_px *= ShrinkFactor(left.p.n());
  if (feature.HasDepth() && !ImproveDisparities(landmark, seen, RightSegment(feature), improved)) return false;
  feature = improved;
  return true;
}

bool KeyframeMeasurements::ImproveDisparities(const LineLandmark& landmark, Observations<StereoLine> seen,
                                              const Segment2& right, StereoLine& feature) const {
  EndMeans means;
  for (const auto& [id, observation] : seen) {
    const StereoLine& measured = *observation.feature;
    const auto expected = Project(*observation.T_c_odom, landmark.segment_odom, camera_);
    if (!expected || !measured.HasDepth()) continue;
    const Segment2 projected = expected->Right();
    const double sigma =
        Hypot(measured.sigma_px, std::max(measured.sigma_disparity_p_px, measured.sigma_disparity_q_px));
    means.Add(projected.p, projected.q, RightSegment(measured), sigma);
  }
  const auto here = Project(frames_.back().T_c_odom, landmark.segment_odom, camera_);
  if (!here || means.p.n() == 0) return false;
  const Segment2 mean = means.Line(here->Right().p, here->Right().q, right);
  const auto d_p = DisparityOn(feature.left.segment.p, mean);
  const auto d_q = DisparityOn(feature.left.segment.q, mean);
  if (!d_p || !d_q || *d_p <= 0.0 || *d_q <= 0.0) return false;
  feature.disparity_p_px = *d_p;
  feature.disparity_q_px = *d_q;
  feature.sigma_disparity_p_px *= ShrinkFactor(means.p.n());
  feature.sigma_disparity_q_px *= ShrinkFactor(means.q.n());
  return true;
}

bool KeyframeMeasurements::Expect(const PointLandmark&, StereoPoint&) const { return true; }

bool KeyframeMeasurements::Expect(const LineLandmark& landmark, StereoLine& feature) const {
  const SE3& T_c_odom = frames_.back().T_c_odom;
  const Segment3 in_camera{T_c_odom * landmark.segment_odom.p, T_c_odom * landmark.segment_odom.q};
  const auto visible = ProjectSegment(in_camera, camera_, 0.0);
  if (!visible) return false;
  const auto s_p = AlongLine(in_camera, visible->p, camera_);
  const auto s_q = AlongLine(in_camera, visible->q, camera_);
  if (!s_p || !s_q) return false;
  const Eigen::Vector3d along = in_camera.q - in_camera.p;
  feature.left.segment = *visible;
  if (!feature.HasDepth()) return true;
  feature.disparity_p_px = camera_.FocalBaseline() / (in_camera.p + *s_p * along).z();
  feature.disparity_q_px = camera_.FocalBaseline() / (in_camera.p + *s_q * along).z();
  return feature.HasDepth();
}

}  // namespace plslam::vo
