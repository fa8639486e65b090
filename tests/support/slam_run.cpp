// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/slam_run.h"

#include <utility>

#include "core/map/map_follower.h"
#include "tests/support/steady_ms.h"
#include "vo_process/node/vo_messages.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {
namespace {

SE3 Blend(const SE3& a, const SE3& b, double t) {
  return {a.rotation().slerp(t, b.rotation()), Eigen::Vector3d((1.0 - t) * a.translation() + t * b.translation())};
}

template <class Landmarks>
double MeanObservations(const Landmarks& landmarks) {
  size_t sum = 0;
  for (const auto& [id, landmark] : landmarks) sum += landmark.observations.size();
  return landmarks.empty() ? 0.0 : static_cast<double>(sum) / static_cast<double>(landmarks.size());
}

void Summarise(const Map& map, SlamRun& run) {
  run.keyframes = static_cast<int>(map.keyframes().size());
  run.points = map.points().size();
  run.lines = map.lines().size();
  run.observations_per_point = MeanObservations(map.points());
  run.observations_per_line = MeanObservations(map.lines());
  run.map = map;
}

// Corrections T_w_odom at the keyframes, blended between them.
SE3 CorrectionAt(int64_t frame, const std::map<int64_t, SE3>& corrections) {
  const auto after = corrections.lower_bound(frame);
  if (after == corrections.begin()) return after->second;
  const auto before = std::prev(after);
  if (after == corrections.end()) return before->second;
  const double t = static_cast<double>(frame - before->first) / static_cast<double>(after->first - before->first);
  return Blend(before->second, after->second, t);
}

}  // namespace

std::vector<OdometryFrame> CarriedByKeyframes(std::vector<OdometryFrame> in_odom, const Map& map) {
  std::map<int64_t, SE3> corrections;
  for (const auto& [id, keyframe] : map.keyframes()) {
    corrections[keyframe.frame_id.value] = keyframe.T_w_kf * keyframe.T_odom_kf.Inverse();
  }
  for (const RemovedKeyframe& removed : map.RemovedKeyframes()) {
    corrections.try_emplace(removed.frame_id.value, removed.T_w_kf * removed.T_odom_kf.Inverse());
  }
  if (corrections.empty()) return in_odom;
  for (size_t i = 0; i < in_odom.size(); ++i) {
    in_odom[i].T_odom_l = CorrectionAt(static_cast<int64_t>(i), corrections) * in_odom[i].T_odom_l;
  }
  return in_odom;
}

SlamRun RunSlam(const Dataset& dataset, const vo::VoOptions& vo, const mapping::MappingOptions& mapping, int stride,
                int max_frames) {
  vo::StereoFrontEnd front_end(dataset.rig(), vo);
  vo::Odometry odometry(front_end.camera(), vo, front_end.shutter(),
                        vo.imu.enabled ? vo::MountedImuOf(dataset.rig()) : std::nullopt);
  mapping::Mapper mapper(front_end.camera(), mapping);
  MapFollower replica;
  replica.RememberRemoved();
  const SE3 T_c_l(Rectifier(dataset.rig()).q_l_c().conjugate(), Eigen::Vector3d::Zero());
  SlamRun run;
  std::vector<OdometryFrame> in_odom;
  constexpr SessionId kSession = 1;
  for (int i = 0; i < dataset.size() && static_cast<int>(run.live.size()) < max_frames; i += stride) {
    const StereoImages images = dataset.Read(i);
    if (!in_odom.empty()) ExpectImu(dataset, in_odom.back().t_ns, images.t_ns, odometry);
    vo::StageTimer timer(SteadyMs);
    const vo::OdometryResult result = odometry.Track(images.t_ns, odometry.SeePair(front_end, images, timer));
    OdometryFrame frame;
    frame.t_ns = images.t_ns;
    frame.state = result.state;
    frame.T_w_l = dataset.GroundTruth(i);
    frame.T_odom_l = result.T_odom_c * T_c_l;
    frame.T_prev_c = result.T_prev_c;
    frame.motion_covariance = result.motion_covariance;
    frame.T_l_c = T_c_l.Inverse();
    frame.keyframe = result.keyframe.has_value();
    in_odom.push_back(frame);
    frame.T_odom_l = odometry.T_w_odom() * frame.T_odom_l;
    run.live.push_back(frame);
    run.n_bodies = result.n_bodies;
    if (!result.keyframe) continue;
    Keyframe keyframe = vo::ToKeyframe(result, front_end.camera());
    keyframe.name.session = kSession;
    keyframe.t_ns = images.t_ns;
    keyframe.frame_id = FrameId(in_odom.size() - 1);
    if (keyframe.name.number > 0 && vo.map.enabled)
      odometry.Adopt(mapper.map(), {kSession, keyframe.name.number - 1});
    std::string reason;
    const double t0 = SteadyMs();
    mapper.Insert(keyframe, &reason);
    const double t1 = SteadyMs();
    mapper.Adjust(nullptr);
    const double t2 = SteadyMs();
    mapper.Cull();
    replica.Apply(mapper.TakeUpdate());
    run.insert_ms.push_back(t1 - t0);
    run.adjust_ms.push_back(t2 - t1);
    run.figures.push_back(mapper.figures());
  }
  Summarise(replica.map(), run);
  run.camera = front_end.camera();
  run.features = mapper.Store().features;
  run.final = CarriedByKeyframes(std::move(in_odom), replica.map());
  return run;
}

}  // namespace plslam::test
