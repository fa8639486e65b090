// SPDX-License-Identifier: BSD-3-Clause
#include "core/bus/messages/map_convert.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/bus/messages/convert.h"
#include "plslam/loop_edge_t.hpp"
#include "plslam/map_adjustment_t.hpp"
#include "plslam/map_id_t.hpp"
#include "plslam/map_keyframe_t.hpp"
#include "plslam/map_line_t.hpp"
#include "plslam/map_point_t.hpp"
#include "plslam/map_totals_t.hpp"
#include "plslam/map_version_t.hpp"
#include "plslam/moved_keyframe_t.hpp"

namespace plslam::bus {
namespace {

/// As many as a keyframe may have features.
constexpr int32_t kMaxFeature = 200'000;

/// Clamped to a finite value, since the reader would reject infinity: a landmark may have any uncertainty.
float ToFiniteFloat(double value) {
  constexpr double kMax = std::numeric_limits<float>::max();
  return static_cast<float>(std::isfinite(value) ? std::clamp(value, -kMax, kMax) : value);
}

template <int N, class Number, size_t kNumbers>
void TriangleToArray(const Eigen::Matrix<double, N, N>& covariance, Number (&values)[kNumbers]) {
  static_assert(kNumbers == N * (N + 1) / 2);
  size_t k = 0;
  for (int row = 0; row < N; ++row) {
    for (int column = row; column < N; ++column) {
      if constexpr (std::is_same_v<Number, float>) {
        values[k++] = ToFiniteFloat(covariance(row, column));
      } else {
        values[k++] = covariance(row, column);
      }
    }
  }
}

/// Finite, and no variance negative.
template <int N, class Number, size_t kNumbers>
std::optional<Eigen::Matrix<double, N, N>> TriangleFromArray(const Number (&values)[kNumbers]) {
  static_assert(kNumbers == N * (N + 1) / 2);
  Eigen::Matrix<double, N, N> covariance;
  size_t k = 0;
  for (int row = 0; row < N; ++row) {
    for (int column = row; column < N; ++column) {
      covariance(row, column) = covariance(column, row) = static_cast<double>(values[k++]);
    }
  }
  const bool ok = covariance.allFinite() && covariance.diagonal().minCoeff() >= 0.0;
  return ok ? std::optional(covariance) : std::nullopt;
}

void PositionToArray(const Eigen::Vector3d& p, double (&values)[3]) { std::copy_n(p.data(), 3, &values[0]); }

std::optional<Eigen::Vector3d> PositionFromArray(const double (&values)[3]) {
  const Eigen::Vector3d p(values[0], values[1], values[2]);
  return p.allFinite() ? std::optional(p) : std::nullopt;
}

std::vector<observation_t> ToMessages(const std::vector<Observation>& observations) {
  std::vector<observation_t> messages(observations.size());
  for (size_t i = 0; i < observations.size(); ++i) {
    messages[i].keyframe_id = observations[i].keyframe_id().value;
    messages[i].feature = observations[i].feature;
  }
  return messages;
}

std::optional<std::vector<Observation>> FromMessages(const std::vector<observation_t>& messages) {
  std::vector<Observation> observations;
  observations.reserve(messages.size());
  int64_t last = -1;
  for (const observation_t& message : messages) {
    const bool ok = message.keyframe_id > last && message.keyframe_id <= Observation::kMaxId &&
                    message.feature >= 0 && message.feature < kMaxFeature;
    if (!ok) return std::nullopt;
    last = message.keyframe_id;
    observations.push_back({KeyframeId(message.keyframe_id), message.feature});
  }
  return observations;
}

}  // namespace

map_id_t ToMessage(const MapId& map) {
  map_id_t message{};
  message.origin = map.origin.value;
  message.n_replaced = map.n_replaced;
  return message;
}

std::optional<MapId> FromMessage(const map_id_t& message) {
  if (message.n_replaced < 0) return std::nullopt;
  return MapId{SourceId(message.origin), message.n_replaced};
}

map_version_t ToMessage(const std::optional<MapVersion>& version) {
  map_version_t message{};
  if (!version) return message;
  message.map = ToMessage(version->map);
  message.numbering = version->numbering.value;
  message.number = version->number;
  return message;
}

bool FromMessage(const map_version_t& message, std::optional<MapVersion>& version) {
  const std::optional<MapId> map = FromMessage(message.map);
  const SourceId numbering(message.numbering);
  version.reset();
  if (!map || message.number < 0) return false;
  if (numbering != SourceId()) version = {*map, numbering, message.number};
  return true;
}

map_keyframe_t ToMessage(const MapKeyframe& keyframe) {
  map_keyframe_t message{};
  message.id = keyframe.id.value;
  message.session = keyframe.name.session.value;
  message.session_keyframe_id = keyframe.name.number;
  message.frame_id = keyframe.frame_id.value;
  message.t_ns = keyframe.t_ns;
  message.T_w_kf = ToMessage(keyframe.T_w_kf);
  TriangleToArray<6>(keyframe.covariance, message.covariance);
  message.T_odom_kf = ToMessage(keyframe.T_odom_kf);
  ToArray(keyframe.up, message.up_kf, message.up_sigma_rad);
  message.previous_id = keyframe.previous_id.value;
  message.T_prevkf_kf = ToMessage(keyframe.T_prevkf_kf);
  TriangleToArray<6>(keyframe.relative_covariance, message.relative_covariance);
  message.parent_id = keyframe.parent_id.value;
  return message;
}

std::optional<MapKeyframe> FromMessage(const map_keyframe_t& message) {
  const auto T_w_kf = FromMessage(message.T_w_kf);
  const auto covariance = TriangleFromArray<6>(message.covariance);
  const auto T_odom_kf = FromMessage(message.T_odom_kf);
  const auto T_prevkf_kf = FromMessage(message.T_prevkf_kf);
  const auto relative_covariance = TriangleFromArray<6>(message.relative_covariance);
  std::optional<UpDirection> up;
  const bool values_ok = T_w_kf && covariance && T_odom_kf && FromArray(message.up_kf, message.up_sigma_rad, up) &&
                         T_prevkf_kf && relative_covariance;
  // Parents and predecessors are older, so that the map can build a tree of them.
  const bool ids_ok = message.id >= 0 && message.session_keyframe_id >= 0 && message.frame_id >= 0 &&
                      message.previous_id >= -1 && message.previous_id < message.id && message.parent_id >= -1 &&
                      message.parent_id < message.id;
  if (!values_ok || !ids_ok) return std::nullopt;
  return MapKeyframe{.id = KeyframeId(message.id),
                     .name = {SessionId(message.session), message.session_keyframe_id},
                     .frame_id = FrameId(message.frame_id),
                     .t_ns = message.t_ns,
                     .T_w_kf = *T_w_kf,
                     .covariance = *covariance,
                     .T_odom_kf = *T_odom_kf,
                     .up = up,
                     .previous_id = KeyframeId(message.previous_id),
                     .T_prevkf_kf = *T_prevkf_kf,
                     .relative_covariance = *relative_covariance,
                     .parent_id = KeyframeId(message.parent_id)};
}

moved_keyframe_t ToMessage(const MovedKeyframe& keyframe) {
  moved_keyframe_t message{};
  message.id = keyframe.id.value;
  message.T_w_kf = ToMessage(keyframe.T_w_kf);
  TriangleToArray<6>(keyframe.covariance, message.covariance);
  return message;
}

std::optional<MovedKeyframe> FromMessage(const moved_keyframe_t& message) {
  const auto T_w_kf = FromMessage(message.T_w_kf);
  const auto covariance = TriangleFromArray<6>(message.covariance);
  if (!T_w_kf || !covariance || message.id < 0) return std::nullopt;
  return MovedKeyframe{KeyframeId(message.id), *T_w_kf, *covariance};
}

map_point_t ToMessage(const MapPoint& point) {
  map_point_t message{};
  message.id = point.id.value;
  PositionToArray(point.p_w, message.p_w_m);
  TriangleToArray<3>(point.covariance, message.covariance_m2);
  message.angle_rad = point.angle_rad;
  message.octave = static_cast<int8_t>(point.octave);
  message.depth_m = point.depth_m;
  ToBytes(point.descriptor, message.descriptor);
  message.observations = ToMessages(point.observations);
  message.n_observations = static_cast<int32_t>(message.observations.size());
  return message;
}

std::optional<MapPoint> FromMessage(const map_point_t& message) {
  const auto p_w = PositionFromArray(message.p_w_m);
  const auto covariance = TriangleFromArray<3>(message.covariance_m2);
  auto observations = FromMessages(message.observations);
  const bool rest_ok = message.id >= 0 && std::isfinite(message.angle_rad) && message.octave >= 0 &&
                       message.octave <= kMaxOctave && std::isfinite(message.depth_m) && message.depth_m > 0.0;
  if (!p_w || !covariance || !observations || !rest_ok) return std::nullopt;
  return MapPoint{.id = LandmarkId(message.id),
                  .p_w = *p_w,
                  .covariance = *covariance,
                  .descriptor = FromBytes(message.descriptor),
                  .angle_rad = message.angle_rad,
                  .octave = static_cast<uint8_t>(message.octave),
                  .depth_m = message.depth_m,
                  .observations = std::move(*observations)};
}

map_line_t ToMessage(const MapLine& line) {
  map_line_t message{};
  message.id = line.id.value;
  PositionToArray(line.segment_w.p, message.p_w_m);
  PositionToArray(line.segment_w.q, message.q_w_m);
  TriangleToArray<3>(line.covariance_p, message.covariance_p_m2);
  TriangleToArray<3>(line.covariance_q, message.covariance_q_m2);
  ToBytes(line.descriptor, message.descriptor);
  message.observations = ToMessages(line.observations);
  message.n_observations = static_cast<int32_t>(message.observations.size());
  return message;
}

std::optional<MapLine> FromMessage(const map_line_t& message) {
  const auto p = PositionFromArray(message.p_w_m);
  const auto q = PositionFromArray(message.q_w_m);
  const auto covariance_p = TriangleFromArray<3>(message.covariance_p_m2);
  const auto covariance_q = TriangleFromArray<3>(message.covariance_q_m2);
  auto observations = FromMessages(message.observations);
  if (!p || !q || !covariance_p || !covariance_q || !observations || message.id < 0) return std::nullopt;
  return MapLine{.id = LandmarkId(message.id),
                 .segment_w = {*p, *q},
                 .covariance_p = *covariance_p,
                 .covariance_q = *covariance_q,
                 .descriptor = FromBytes(message.descriptor),
                 .observations = std::move(*observations)};
}

map_totals_t ToMessage(const MapTotals& totals) {
  map_totals_t message{};
  message.n_keyframes = totals.keyframes;
  message.n_points = totals.points;
  message.n_lines = totals.lines;
  message.n_point_observations = totals.point_observations;
  message.n_line_observations = totals.line_observations;
  message.n_loops = totals.loops;
  return message;
}

std::optional<MapTotals> FromMessage(const map_totals_t& m) {
  const int64_t least =
      std::min({m.n_keyframes, m.n_points, m.n_lines, m.n_point_observations, m.n_line_observations, m.n_loops});
  if (least < 0) return std::nullopt;
  return MapTotals{m.n_keyframes, m.n_points, m.n_lines, m.n_point_observations, m.n_line_observations, m.n_loops};
}

map_adjustment_t ToMessage(const AdjustmentFigures& figures) {
  map_adjustment_t message{};
  message.n_keyframes = figures.n_keyframes;
  message.n_fixed_keyframes = figures.n_fixed_keyframes;
  message.n_points = figures.n_points;
  message.n_lines = figures.n_lines;
  message.n_outliers = figures.n_outliers;
  message.rms_before = figures.rms_before;
  message.rms_after = figures.rms_after;
  message.reprojection_before_px = figures.reprojection_before_px;
  message.reprojection_after_px = figures.reprojection_after_px;
  return message;
}

std::optional<AdjustmentFigures> FromMessage(const map_adjustment_t& m) {
  const int32_t least = std::min({m.n_keyframes, m.n_fixed_keyframes, m.n_points, m.n_lines, m.n_outliers});
  const auto is_rms = [](double value) { return std::isfinite(value) && value >= 0.0; };
  const bool ok = least >= 0 && is_rms(m.rms_before) && is_rms(m.rms_after) && is_rms(m.reprojection_before_px) &&
                  is_rms(m.reprojection_after_px);
  if (!ok) return std::nullopt;
  return AdjustmentFigures{m.n_keyframes,          m.n_fixed_keyframes, m.n_points,  m.n_lines,
                           m.n_outliers,           m.rms_before,        m.rms_after, m.reprojection_before_px,
                           m.reprojection_after_px};
}

loop_edge_t ToMessage(const LoopEdge& loop) {
  loop_edge_t message{};
  message.old_keyframe_id = loop.old_keyframe_id.value;
  message.keyframe_id = loop.keyframe_id.value;
  message.T_old_kf = ToMessage(loop.T_old_kf);
  TriangleToArray<6>(loop.covariance, message.covariance);
  message.n_points = loop.n_points;
  message.n_lines = loop.n_lines;
  return message;
}

std::optional<LoopEdge> FromMessage(const loop_edge_t& message) {
  const auto T_old_kf = FromMessage(message.T_old_kf);
  const auto covariance = TriangleFromArray<6>(message.covariance);
  const bool ids_ok = message.old_keyframe_id >= 0 && message.keyframe_id > message.old_keyframe_id;
  const bool ok = T_old_kf && covariance && ids_ok && message.n_points >= 0 && message.n_lines >= 0;
  if (!ok) return std::nullopt;
  return LoopEdge{KeyframeId(message.old_keyframe_id),
                  KeyframeId(message.keyframe_id),
                  *T_old_kf,
                  *covariance,
                  message.n_points,
                  message.n_lines};
}

}  // namespace plslam::bus
