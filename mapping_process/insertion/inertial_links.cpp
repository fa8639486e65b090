// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/inertial_links.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "core/inertial/inertial_filter.h"
#include "core/map/vertical.h"

namespace plslam::mapping {
namespace {

// Number of links that are kept: the newest, of all sessions.
constexpr size_t kMost = 100;
// Rotation by a change of the bias up to which a motion is linear in it.
constexpr double kLinear_rad = 0.01;
// Gravity differs from its standard value by 0.3 %.
constexpr double kMagnitude_m_s2 = 0.03;

GravityPrior GravityAlong(const Vertical& vertical) {
  const Eigen::Matrix3d along = vertical.up_w * vertical.up_w.transpose();
  const double across_m_s2 = vertical.sigma_rad * kGravity_m_s2;
  return {-kGravity_m_s2 * vertical.up_w, across_m_s2 * across_m_s2 * (Eigen::Matrix3d::Identity() - along) +
                                              kMagnitude_m_s2 * kMagnitude_m_s2 * along};
}

}  // namespace

void InertialLinks::Add(const MapKeyframe& keyframe, const InertialInterval& interval, const Map& map) {
  if (keyframe.previous_id < 0 || interval.empty()) return;
  const MapKeyframe* previous = map.FindKeyframe(keyframe.previous_id);
  if (previous == nullptr) return;
  // Unsigned, because stamps may have any value.
  const uint64_t apart_ns = static_cast<uint64_t>(keyframe.t_ns) - static_cast<uint64_t>(previous->t_ns);
  if (apart_ns != interval.LengthUntil(interval.to_ns)) return;
  biases_[keyframe.name.session] = interval.bias;
  links_[keyframe.id] = {keyframe.previous_id, keyframe.name.session, interval, std::nullopt};
  if (links_.size() <= kMost) return;
  links_.erase(links_.begin());
  std::erase_if(biases_, [this](const auto& bias) {
    return std::none_of(links_.begin(), links_.end(),
                        [&](const auto& link) { return link.second.session == bias.first; });
  });
}

void InertialLinks::Remove(KeyframeId keyframe_id) {
  const auto next = std::find_if(links_.begin(), links_.end(),
                                 [&](const auto& link) { return link.second.previous_id == keyframe_id; });
  const auto gone = links_.find(keyframe_id);
  if (next != links_.end()) {
    Link& later = next->second;
    InertialInterval joined = gone == links_.end() ? InertialInterval() : std::move(gone->second.interval);
    const bool follows = !joined.empty() && joined.to_ns == later.interval.from_ns &&
                         joined.LengthUntil(later.interval.to_ns) <= InertialInterval::kLongest_ns;
    if (follows) {
      joined.Append(later.interval.samples, later.interval.to_ns);
      later = {gone->second.previous_id, later.session, std::move(joined), std::nullopt};
    } else {
      links_.erase(next);
    }
  }
  links_.erase(keyframe_id);
}

const Preintegration* InertialLinks::Sensed(const ImuBias& bias, Link& link) {
  const double length_s = 1e-9 * static_cast<double>(link.interval.LengthUntil(link.interval.to_ns));
  const bool is_linear = (link.interval.bias.mean.rate_rad_s - bias.rate_rad_s).norm() * length_s < kLinear_rad;
  if (!is_linear) {
    link.interval.bias.mean = bias;
    link.sensed.reset();
  }
  if (!link.sensed) link.sensed = link.interval.Motion();
  return link.sensed ? &*link.sensed : nullptr;
}

void InertialLinks::AddTo(MapBundle& bundle, const Map& map) {
  if (links_.empty()) return;
  const auto vertical = VerticalFromGravity(map);
  if (!vertical) return;
  bundle.problem.gravity = GravityAlong(*vertical);
  std::map<KeyframeId, int> poses;
  for (size_t i = 0; i < bundle.keyframes.size(); ++i) poses[bundle.keyframes[i]] = static_cast<int>(i);
  for (auto& [id, link] : links_) {
    const auto a = poses.find(link.previous_id), b = poses.find(id);
    if (a == poses.end() || b == poses.end()) continue;
    const ImuBiasEstimate& bias = biases_.at(link.session);
    if (const Preintegration* sensed = Sensed(bias.mean, link))
      bundle.problem.inertial_motions.push_back({a->second, b->second, link.interval.T_c_imu, *sensed, bias});
  }
}

}  // namespace plslam::mapping
