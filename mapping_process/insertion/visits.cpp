// SPDX-License-Identifier: BSD-3-Clause
#include "mapping_process/insertion/visits.h"

#include <algorithm>

namespace plslam::mapping {
namespace {

constexpr double kLeastStep_m = 1e-3;
// Distance up to which keyframes are at the same place, relative to the mean step between keyframes; and length of a
// path away from it and back, relative to that distance.
constexpr double kNear = 3.0;
constexpr double kAway = 3.0;

}  // namespace

double Visits::Session::Near_m() const {
  return kNear * std::max(kLeastStep_m, n_steps > 0 ? travelled_m / static_cast<double>(n_steps) : 0.0);
}

double Visits::Near_m(const MapKeyframe& keyframe) const {
  const auto session = sessions_.find(keyframe.name.session);
  return session == sessions_.end() ? 0.0 : session->second.Near_m();
}

void Visits::Add(const MapKeyframe& keyframe) {
  Session& session = sessions_[keyframe.name.session];
  if (session.first_id < 0) session.first_id = keyframe.id;
  if (keyframe.previous_id >= 0) {
    session.travelled_m += keyframe.T_prevkf_kf.translation().norm();
    ++session.n_steps;
  }
  session.newest_id = keyframe.id;
  session.by_keyframe_m[keyframe.id] = session.travelled_m;
  ForgetSessions();
}

void Visits::ForgetSessions() {
  if (sessions_.size() <= kRunningSessions) return;
  sessions_.erase(std::min_element(sessions_.begin(), sessions_.end(), [](const auto& a, const auto& b) {
    return a.second.newest_id < b.second.newest_id;
  }));
}

void Visits::Remove(KeyframeId keyframe_id) {
  for (auto& [id, session] : sessions_) session.by_keyframe_m.erase(keyframe_id);
}

Visits::Moment Visits::MomentOf(const MapKeyframe& keyframe) const {
  Moment moment{keyframe.name.session, keyframe.id, 0.0};
  const auto session = sessions_.find(keyframe.name.session);
  if (session == sessions_.end()) return moment;
  const auto travelled = session->second.by_keyframe_m.find(keyframe.id);
  if (travelled != session->second.by_keyframe_m.end()) moment.travelled_m = travelled->second;
  return moment;
}

bool Visits::IsBefore(const Moment& earlier, double distance_m, const MapKeyframe& keyframe) const {
  if (earlier.keyframe_id >= keyframe.id) return false;
  const auto session = sessions_.find(keyframe.name.session);
  if (session == sessions_.end() || keyframe.id < session->second.first_id)
    return earlier.session != keyframe.name.session;
  if (earlier.keyframe_id < session->second.first_id) return true;
  if (earlier.session != keyframe.name.session) return false;
  const double path_m = MomentOf(keyframe).travelled_m - earlier.travelled_m;
  return path_m > distance_m + kAway * session->second.Near_m();
}

bool Visits::IsBefore(const MapKeyframe& earlier, const MapKeyframe& keyframe) const {
  const double distance_m = (earlier.T_w_kf.translation() - keyframe.T_w_kf.translation()).norm();
  return IsBefore(MomentOf(earlier), distance_m, keyframe);
}

}  // namespace plslam::mapping
