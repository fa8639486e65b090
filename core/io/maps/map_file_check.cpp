// SPDX-License-Identifier: BSD-3-Clause
#include "core/io/maps/map_file_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plslam::map_file {
namespace {

constexpr double kMaxUnitError = 1e-6;
constexpr int kMaxOctave = 31;
constexpr double kMaxPixel = 1e6;

template <class... T>
void Demand(bool condition, fmt::format_string<T...> what, T&&... values) {
  if (!condition) throw std::runtime_error(fmt::format(what, std::forward<T>(values)...));
}

bool IsPose(const SE3& pose) { return pose.IsFinite() && std::abs(pose.rotation().norm() - 1.0) <= kMaxUnitError; }

template <int N>
bool IsCovariance(const Eigen::Matrix<double, N, N>& covariance) {
  return covariance.allFinite() && covariance.diagonal().minCoeff() >= 0.0;
}

bool IsDeviation(double sigma) { return std::isfinite(sigma) && sigma > 0.0; }

bool IsPixel(const Eigen::Vector2d& px) { return px.allFinite() && px.cwiseAbs().maxCoeff() <= kMaxPixel; }

bool IsFeature(const StereoPoint& p) {
  const PointFeature& left = p.left;
  return IsPixel(left.px) && std::isfinite(left.response) && std::isfinite(left.angle_rad) && left.octave >= 0 &&
         left.octave <= kMaxOctave && std::isfinite(left.scale) && std::isfinite(p.disparity_px) &&
         IsDeviation(p.sigma_px) && IsDeviation(p.sigma_disparity_px);
}

bool IsFeature(const StereoLine& l) {
  const LineFeature& left = l.left;
  return IsPixel(left.segment.p) && IsPixel(left.segment.q) && std::isfinite(left.response) && left.octave >= 0 &&
         left.octave <= kMaxOctave && std::isfinite(l.disparity_p_px) && std::isfinite(l.disparity_q_px) &&
         IsDeviation(l.sigma_px) && IsDeviation(l.sigma_disparity_p_px) && IsDeviation(l.sigma_disparity_q_px);
}

template <class Feature>
void CheckObservations(const char* kind, LandmarkId id, const std::vector<Observation>& observations,
                       const KeyframeFeatures& features, std::span<const Feature> FeaturesView::*of) {
  KeyframeId last;
  for (const Observation& observation : observations) {
    Demand(observation.keyframe_id() > last,
           "{} {} has observations not in ascending order of keyframes ({} after {})", kind, id,
           observation.keyframe_id(), last);
    last = observation.keyframe_id();
    const auto found = features.find(observation.keyframe_id());
    const auto n = found == features.end() ? 0 : static_cast<int64_t>((found->second.*of).size());
    Demand(observation.feature >= 0 && observation.feature < n,
           "{} {} is observed as feature {} of keyframe {}, which has {}", kind, id, observation.feature,
           observation.keyframe_id(), n);
  }
}

template <class AnId, class Value>
AnId LastId(const IdMap<AnId, Value>& values) {
  return values.empty() ? -1 : values.rbegin()->first;
}

}  // namespace

void Check(const MapKeyframe& k) {
  Demand(k.id >= 0 && k.name.number >= 0 && k.frame_id >= 0, "keyframe {} has a negative number", k.id);
  Demand(k.previous_id >= -1 && k.previous_id < k.id && k.parent_id >= -1 && k.parent_id < k.id,
         "keyframe {} follows keyframe {} and is attached to {}, which must be older", k.id, k.previous_id,
         k.parent_id);
  Demand(IsPose(k.T_w_kf) && IsPose(k.T_odom_kf) && IsPose(k.T_prevkf_kf),
         "keyframe {} has a pose that is not finite or whose rotation is not unit", k.id);
  Demand(IsCovariance<6>(k.covariance) && IsCovariance<6>(k.relative_covariance),
         "keyframe {} has an invalid covariance", k.id);
}

void Check(KeyframeId keyframe_id, const FeaturesView& features) {
  const auto is_feature = [](const auto& feature) { return IsFeature(feature); };
  Demand(std::all_of(features.points.begin(), features.points.end(), is_feature) &&
             std::all_of(features.lines.begin(), features.lines.end(), is_feature),
         "keyframe {} has a feature with invalid values", keyframe_id);
}

void Check(KeyframeId keyframe_id, const UpDirection& up, const Map& map) {
  Demand(map.FindKeyframe(keyframe_id) != nullptr, "there is a vertical for keyframe {}, which does not exist",
         keyframe_id);
  Demand(up.IsValid(), "the vertical of keyframe {} is not a unit vector with a positive sigma", keyframe_id);
}

void Check(KeyframeId keyframe_id, const TakenImage& image, const KeyframeFeatures& features) {
  Demand(features.contains(keyframe_id), "an image belongs to keyframe {}, which has no features", keyframe_id);
  const auto is_place = [](int px) { return std::abs(px) <= kMaxPixel; };
  const auto is_size = [](int px) { return px >= 1 && px <= kMaxPixel; };
  const bool is_one = is_place(image.left_px) && is_place(image.top_px) && is_size(image.width_px) &&
                      is_size(image.height_px) && image.f_px >= 1.0 && image.f_px <= kMaxPixel;
  Demand(is_one,
         "the image of keyframe {} is invalid: {} x {} px from ({}, {}) on, taken with a focal length of {} px",
         keyframe_id, image.width_px, image.height_px, image.left_px, image.top_px, image.f_px);
}

void Check(const MapPoint& p, const KeyframeFeatures& features) {
  const bool ok = p.id >= 0 && p.p_w.allFinite() && IsCovariance<3>(p.covariance.matrix()) &&
                  std::isfinite(p.angle_rad) && p.octave >= 0 && p.octave <= kMaxOctave && std::isfinite(p.depth_m) &&
                  p.depth_m > 0.0;
  Demand(ok, "point {} has invalid values", p.id);
  CheckObservations("point", p.id, p.observations, features, &FeaturesView::points);
}

void Check(const MapLine& l, const KeyframeFeatures& features) {
  const bool ok = l.id >= 0 && l.segment_w.p.allFinite() && l.segment_w.q.allFinite() &&
                  IsCovariance<3>(l.covariance_p.matrix()) && IsCovariance<3>(l.covariance_q.matrix());
  Demand(ok, "line {} has invalid values", l.id);
  CheckObservations("line", l.id, l.observations, features, &FeaturesView::lines);
}

void Check(const LoopEdge& loop) {
  const bool ok = loop.old_keyframe_id >= 0 && loop.keyframe_id > loop.old_keyframe_id && loop.n_points >= 0 &&
                  loop.n_lines >= 0 && IsPose(loop.T_old_kf) && IsCovariance<6>(loop.covariance);
  Demand(ok, "the loop from keyframe {} to {} has invalid values", loop.old_keyframe_id, loop.keyframe_id);
}

void CheckObservationsOnce(const Map& map, int64_t point_observations, int64_t line_observations) {
  const MapTotals totals = map.Totals();
  Demand(totals.point_observations == point_observations && totals.line_observations == line_observations,
         "a feature belongs to several landmarks");
}

void CheckWhole(const StoredMap& stored) {
  const Map& map = stored.map;
  Demand(stored.next_keyframe_id.value <= Observation::kMaxId,
         "the next keyframe would be {}, but no map can have more than {}", stored.next_keyframe_id,
         Observation::kMaxId);
  Demand(stored.next_keyframe_id > LastId(map.keyframes()), "the next keyframe would be {}, but keyframe {} exists",
         stored.next_keyframe_id, LastId(map.keyframes()));
  Demand(stored.next_point_id > LastId(map.points()), "the next point would be {}, but point {} exists",
         stored.next_point_id, LastId(map.points()));
  Demand(stored.next_line_id > LastId(map.lines()), "the next line would be {}, but line {} exists",
         stored.next_line_id, LastId(map.lines()));
  Demand(stored.version >= 0, "the map's version is {}", stored.version);
  for (const auto& [id, features] : stored.features) {
    Demand(map.FindKeyframe(id) != nullptr, "features belong to keyframe {}, which is not in the map", id);
  }
  for (const auto& [session, newest] : stored.sessions) {
    if (newest.keyframe_id < 0 && session != stored.newest_session) continue;
    const MapKeyframe* keyframe = map.FindKeyframe(newest.keyframe_id);
    Demand(keyframe != nullptr && keyframe->name.session == session,
           "session {} ends with keyframe {}, which is not in the map or not of this session", session,
           newest.keyframe_id);
  }
}

}  // namespace plslam::map_file
