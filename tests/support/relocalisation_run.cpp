// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/relocalisation_run.h"

#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <utility>

#include "mapping_process/mapper.h"
#include "vo_process/node/vo_messages.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {
namespace {

constexpr SessionId kMapSession = 1;

/// State of the three processes after the dataset.
struct Mapped {
  vo::Odometry odometry;
  Map map;
  loop::LoopCloser closer;
  int64_t t_ns = 0;
};

StereoFeatures See(vo::StereoFrontEnd& front_end, const StereoImages& images, vo::Odometry& odometry) {
  vo::StageTimer timer([] { return 0.0; });
  return odometry.SeePair(front_end, images, timer);
}

Mapped MakeMap(const Dataset& dataset, const PlaceRecogniser& places, vo::StereoFrontEnd& front_end,
               const vo::VoOptions& vo, const mapping::MappingOptions& mapping, const loop::LoopOptions& loops) {
  vo::Odometry odometry(front_end.camera(), vo);
  mapping::Mapper mapper(front_end.camera(), mapping);
  int64_t newest = -1;
  loop::LoopCloser closer(front_end.camera(), places, loops);
  for (int i = 0; i < dataset.size(); ++i) {
    const StereoImages images = dataset.Read(i);
    const vo::OdometryResult result = odometry.Track(images.t_ns, See(front_end, images, odometry));
    if (!result.keyframe) continue;
    Keyframe keyframe = vo::ToKeyframe(result, front_end.camera());
    keyframe.name.session = kMapSession;
    keyframe.t_ns = images.t_ns;
    keyframe.frame_id = i;
    newest = keyframe.name.number;
    if (newest > 0) odometry.Adopt(mapper.map(), {kMapSession, newest - 1});
    std::string reason;
    mapper.Insert(keyframe, &reason);
    mapper.Adjust(nullptr);
    mapper.Cull();
    closer.AddKeyframe(keyframe);
    const LoopClosure loop = closer.Check(mapper.map(), {kMapSession, keyframe.name.number});
    if (loop.kind == LoopClosure::Kind::kLoop) mapper.Correct(loop, &reason);
  }
  closer.Follow(mapper.map());
  odometry.Adopt(mapper.map(), {kMapSession, newest});
  const int last = dataset.size() - 1;
  return {std::move(odometry), mapper.map(), std::move(closer), dataset.t_ns(last)};
}

/// Returns the true pose of a frame in the map, relative to the keyframe nearest in time, so that drift elsewhere in
/// the map does not count.
SE3 PlaceInMap(const Dataset& dataset, const Map& map, int frame) {
  const MapKeyframe* nearest = nullptr;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (nearest == nullptr || std::abs(keyframe.frame_id.value - frame) < std::abs(nearest->frame_id.value - frame)) {
      nearest = &keyframe;
    }
  }
  const SE3 T_w_kf_true = *dataset.GroundTruth(static_cast<int>(nearest->frame_id.value));
  return nearest->T_w_kf * T_w_kf_true.Inverse() * *dataset.GroundTruth(frame);
}

bool IsRight(const SE3& T_w_c, const SE3& truth, const RelocalisationTrials& trials) {
  const Vector6d error = (truth.Inverse() * T_w_c).Log();
  return error.head<3>().norm() < trials.max_error_m &&
         error.tail<3>().norm() * 180.0 / std::numbers::pi < trials.max_error_deg;
}

void Try(const Dataset& dataset, vo::StereoFrontEnd& front_end, const Mapped& mapped,
         const RelocalisationTrials& trials, RelocalisationTrial& trial) {
  vo::Odometry odometry = mapped.odometry;
  int64_t t_ns = mapped.t_ns;
  const int64_t step_ns = dataset.t_ns(1) - dataset.t_ns(0);
  for (int i = 0; i < trials.covered_frames; ++i) odometry.Track(t_ns += step_ns, {});
  for (int i = 0; i < trials.seen_frames; ++i) {
    const int frame = trial.to_frame + i;
    const vo::OdometryResult result = odometry.Track(t_ns += step_ns, See(front_end, dataset.Read(frame), odometry));
    const bool lost = result.state == TrackingState::kLost;
    const SE3 truth = PlaceInMap(dataset, mapped.map, frame);
    const bool right = !lost && IsRight(odometry.T_w_odom() * result.T_odom_c, truth, trials);
    if (right && trial.frames_until_right < 0) trial.frames_until_right = i + 1;
    if (!lost && !right) ++(trial.frames_until_right < 0 ? trial.wrong_before : trial.wrong_afterwards);
    if (!lost && !odometry.is_unanchored()) continue;
    ++trial.asked;
    const Relocalisation answer = mapped.closer.Relocalise(mapped.map, result.features);
    if (answer.found) {
      ++trial.answered;
      if (!IsRight(answer.T_w_c, truth, trials)) ++trial.answered_wrongly;
      odometry.Relocalise(mapped.map, answer.keyframe_id, answer.T_w_c * result.T_odom_c.Inverse());
    }
  }
}

}  // namespace

std::vector<RelocalisationTrial> RunRelocalisationTrials(const Dataset& dataset, const PlaceRecogniser& places,
                                                         const vo::VoOptions& vo,
                                                         const mapping::MappingOptions& mapping,
                                                         const loop::LoopOptions& loops,
                                                         const RelocalisationTrials& trials, int n_trials,
                                                         uint64_t seed) {
  vo::StereoFrontEnd front_end(dataset.rig(), vo);
  const Mapped mapped = MakeMap(dataset, places, front_end, vo, mapping, loops);
  std::mt19937_64 random(seed);
  std::vector<RelocalisationTrial> results;
  const int last = dataset.size() - 1;
  const auto n_starts = static_cast<uint64_t>(last - trials.seen_frames);
  for (int attempts = 0; static_cast<int>(results.size()) < n_trials && attempts < 100 * n_trials; ++attempts) {
    RelocalisationTrial trial;
    trial.from_frame = last;
    trial.to_frame = static_cast<int>(random() % n_starts);
    trial.carried_m =
        (dataset.GroundTruth(last)->translation() - dataset.GroundTruth(trial.to_frame)->translation()).norm();
    if (trial.carried_m < trials.min_carried_m) continue;
    Try(dataset, front_end, mapped, trials, trial);
    results.push_back(trial);
  }
  return results;
}

}  // namespace plslam::test
