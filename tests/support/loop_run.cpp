// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/loop_run.h"

#include <time.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

#include "core/map/map_follower.h"
#include "vo_process/node/vo_messages.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::test {
namespace {

constexpr SessionId kSession = 1;
// A revisit is within this of an older keyframe that is at least as many metres of path earlier.
constexpr double kNear_m = 1.0;
constexpr double kNear_rad = 20.0 * std::numbers::pi / 180.0;
constexpr double kBehind_m = 6.0;
constexpr int kShared = 15;

// CPU time of this thread, without other processes.
double NowMs() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Moment {
  int index;
  int64_t t_ns;
};

// Returns the frames of a run and their times.
std::vector<Moment> Schedule(const Dataset& dataset, const LoopRunOptions& options) {
  std::vector<Moment> moments;
  for (int i = 0; i < dataset.size() && static_cast<int>(moments.size()) < options.max_frames; i += options.stride) {
    moments.push_back({i, dataset.t_ns(i)});
  }
  if (!options.forth_and_back || moments.empty()) return moments;
  const int64_t turn_ns = moments.back().t_ns;
  for (int i = static_cast<int>(moments.size()) - 2; i >= 0; --i) {
    const Moment& there = moments[static_cast<size_t>(i)];
    moments.push_back({there.index, turn_ns + (turn_ns - there.t_ns)});
  }
  return moments;
}

class Run {
 public:
  Run(const Dataset& dataset, const PlaceRecogniser& places, const LoopRunOptions& options)
      : dataset_(dataset),
        options_(options),
        front_end_(dataset.rig(), options.vo),
        odometry_(front_end_.camera(), options.vo, front_end_.shutter()),
        mapper_(front_end_.camera(), options.mapping),
        closer_(front_end_.camera(), places, options.loops),
        T_l_c_(Rectifier(dataset.rig()).q_l_c(), Eigen::Vector3d::Zero()) {
    follower_.RememberRemoved();
  }

  LoopRun Play() {
    for (const Moment& moment : Schedule(dataset_, options_)) Frame(moment);
    run_.slam.keyframes = static_cast<int>(mapper_.map().keyframes().size());
    run_.slam.points = mapper_.map().points().size();
    run_.slam.lines = mapper_.map().lines().size();
    run_.slam.map = follower_.map();
    run_.slam.camera = front_end_.camera();
    run_.slam.features = mapper_.Store().features;
    run_.slam.final = AsTheMapHasIt();
    CountRevisits();
    return std::move(run_);
  }

 private:
  void Frame(const Moment& moment);
  void TakeKeyframe(Keyframe keyframe);
  void Note(const LoopClosure& closure);
  void Ask(const StereoFeatures& features, int64_t frame);
  void Correct(const LoopClosure& closure);
  void CountRevisits();
  LoopOfRun Describe(const loop::LoopEvidence& evidence) const;
  std::optional<SE3> TrueRelation(int64_t old_frame, int64_t frame) const;
  std::vector<OdometryFrame> AsTheMapHasIt() const;
  double Ate() const { return AbsoluteTrajectoryError(AsTheMapHasIt()); }

  const Dataset& dataset_;
  const LoopRunOptions& options_;
  vo::StereoFrontEnd front_end_;
  vo::Odometry odometry_;
  mapping::Mapper mapper_;
  MapFollower follower_;
  loop::LoopCloser closer_;
  SE3 T_l_c_;
  std::vector<OdometryFrame> in_odom_;
  LoopRun run_;
};

void Run::Frame(const Moment& moment) {
  const StereoImages images = dataset_.Read(moment.index);
  vo::StageTimer timer(NowMs);
  const vo::OdometryResult result = odometry_.Track(moment.t_ns, odometry_.SeePair(front_end_, images, timer));
  OdometryFrame frame;
  frame.t_ns = moment.t_ns;
  frame.state = result.state;
  frame.T_w_l = dataset_.GroundTruth(moment.index);
  frame.T_odom_l = result.T_odom_c * T_l_c_.Inverse();
  frame.keyframe = result.keyframe.has_value();
  in_odom_.push_back(frame);
  frame.T_odom_l = odometry_.T_w_odom() * frame.T_odom_l;
  frame.n_bodies = result.n_bodies;
  run_.slam.live.push_back(frame);
  run_.slam.n_bodies = result.n_bodies;
  const int64_t index = static_cast<int64_t>(in_odom_.size()) - 1;
  if (options_.ask_every > 0 && index % options_.ask_every == options_.ask_every - 1) Ask(result.features, index);
  if (!result.keyframe) return;
  Keyframe keyframe = vo::ToKeyframe(result, front_end_.camera());
  keyframe.name.session = kSession;
  keyframe.t_ns = moment.t_ns;
  keyframe.frame_id = FrameId(in_odom_.size() - 1);
  if (keyframe.name.number > 0 && options_.vo.map.enabled) {
    odometry_.Adopt(mapper_.map(), {kSession, keyframe.name.number - 1});
  }
  TakeKeyframe(std::move(keyframe));
}

void Run::Ask(const StereoFeatures& features, int64_t frame) {
  const double t0 = NowMs();
  const Relocalisation answer = closer_.Relocalise(mapper_.map(), features);
  run_.ask_ms.push_back(NowMs() - t0);
  ++run_.asked;
  if (!answer.found) return;
  ++run_.found;
  const MapKeyframe& keyframe = *mapper_.map().FindKeyframe(answer.keyframe_id);
  const auto truth = TrueRelation(keyframe.frame_id.value, frame);
  if (!truth) return;
  const SE3 error = truth->Inverse() * (keyframe.T_w_kf.Inverse() * answer.T_w_c);
  run_.found_elsewhere += error.translation().norm() > 0.5 || error.Log().tail<3>().norm() > 0.1;
}

void Run::TakeKeyframe(Keyframe keyframe) {
  std::string reason;
  const double t0 = NowMs();
  mapper_.Insert(keyframe, &reason);
  const double t1 = NowMs();
  mapper_.Adjust(nullptr);
  const double t2 = NowMs();
  mapper_.Cull();
  follower_.Apply(mapper_.TakeUpdate());
  run_.slam.insert_ms.push_back(t1 - t0);
  run_.slam.adjust_ms.push_back(t2 - t1);
  run_.slam.figures.push_back(mapper_.figures());
  if (!options_.loops.enabled) return;
  closer_.AddKeyframe(keyframe);
  const double t3 = NowMs();
  const LoopClosure loop = closer_.Check(mapper_.map(), {kSession, keyframe.name.number});
  run_.check_ms.push_back(NowMs() - t3);
  Note(loop);
  if (loop.kind != LoopClosure::Kind::kLoop) return;
  run_.loop_ms.push_back(run_.check_ms.back());
  run_.ate_before_m.push_back(Ate());
  Correct(loop);
  run_.ate_corrected_m.push_back(Ate());
  if (!loop.more) return;
  const double t4 = NowMs();
  const LoopClosure adjusted =
      loop::AdjustGlobally(closer_.MakeGlobalBundle(mapper_.map(), loop), closer_.options().adjustment, nullptr);
  run_.adjust_ms.push_back(NowMs() - t4);
  Correct(adjusted);
  run_.ate_adjusted_m.push_back(Ate());
}

void Run::Correct(const LoopClosure& closure) {
  std::string reason;
  const double t0 = NowMs();
  if (!mapper_.Correct(closure, &reason)) run_.refused.push_back(reason);
  run_.correct_ms.push_back(NowMs() - t0);
  follower_.Apply(mapper_.TakeUpdate());
}

std::optional<SE3> Run::TrueRelation(int64_t old_frame, int64_t frame) const {
  const auto& old_truth = in_odom_[static_cast<size_t>(old_frame)].T_w_l;
  const auto& truth = in_odom_[static_cast<size_t>(frame)].T_w_l;
  if (!old_truth || !truth) return std::nullopt;
  return (*old_truth * T_l_c_).Inverse() * (*truth * T_l_c_);
}

LoopOfRun Run::Describe(const loop::LoopEvidence& evidence) const {
  LoopOfRun loop;
  loop.evidence = evidence;
  const MapKeyframe* keyframe = mapper_.map().FindKeyframe(evidence.edge.keyframe_id);
  const MapKeyframe* old = mapper_.map().FindKeyframe(evidence.edge.old_keyframe_id);
  if (keyframe == nullptr || old == nullptr) return loop;
  loop.keyframe = keyframe->name;
  loop.frame = keyframe->frame_id.value;
  loop.old_frame = old->frame_id.value;
  const auto truth = TrueRelation(old->frame_id.value, keyframe->frame_id.value);
  if (!truth || evidence.verdict == loop::LoopVerdict::kNotFound) return loop;
  const SE3 error = truth->Inverse() * evidence.edge.T_old_kf;
  loop.error_m = error.translation().norm();
  loop.error_deg = error.Log().tail<3>().norm() * 180.0 / std::numbers::pi;
  return loop;
}

void Run::Note(const LoopClosure& closure) {
  const loop::LoopSearch& search = closer_.last_search();
  for (size_t i = 0; i < search.evidence.size(); ++i) {
    LoopOfRun loop = Describe(search.evidence[i]);
    loop.score = search.candidates[i].score;
    run_.looked_at.push_back(loop);
    if (closure.kind == LoopClosure::Kind::kLoop && search.best == i) run_.loops.push_back(loop);
  }
}

std::vector<OdometryFrame> Run::AsTheMapHasIt() const { return CarriedByKeyframes(in_odom_, follower_.map()); }

// Counts both in the final map.
void Run::CountRevisits() {
  const Map& map = mapper_.map();
  std::map<KeyframeId, double> path_m;
  double total_m = 0.0;
  KeyframeId before = -1;
  bool in_visit = false;
  bool closed = false;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (before >= 0) {
      const auto step = TrueRelation(map.FindKeyframe(before)->frame_id.value, keyframe.frame_id.value);
      if (step) total_m += step->translation().norm();
    }
    path_m[id] = total_m;
    before = id;
    bool again = false;
    bool shared = false;
    for (const auto& [old_id, at_m] : path_m) {
      if (total_m - at_m < kBehind_m) break;
      const auto apart = TrueRelation(map.FindKeyframe(old_id)->frame_id.value, keyframe.frame_id.value);
      if (!apart || apart->translation().norm() > kNear_m || apart->Log().tail<3>().norm() > kNear_rad) continue;
      again = true;
      shared = shared || map.Shared(old_id, id) >= kShared;
    }
    run_.revisits.keyframes += again ? 1 : 0;
    run_.revisits.closed_keyframes += shared ? 1 : 0;
    if (again && !in_visit) ++run_.revisits.total;
    if (!again) closed = false;
    if (shared && !closed) {
      ++run_.revisits.closed;
      closed = true;
    }
    in_visit = again;
  }
}

}  // namespace

LoopRun RunLoops(const Dataset& dataset, const PlaceRecogniser& places, const LoopRunOptions& options) {
  return Run(dataset, places, options).Play();
}

}  // namespace plslam::test
