// SPDX-License-Identifier: BSD-3-Clause
#include "vo_process/node/vo_node.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <utility>

#include "core/bus/messages/convert.h"
#include "core/bus/messages/loop_channel.h"
#include "core/bus/run_loop.h"
#include "core/bus/transport/wire.h"
#include "core/errors/log.h"
#include "core/files/archive.h"
#include "core/run/process_names.h"
#include "core/run/run_counters.h"
#include "plslam/header_t.hpp"
#include "plslam/relocalisation_t.hpp"
#include "plslam/status_t.hpp"
#include "plslam/stream_t.hpp"
#include "vo_process/node/self_calibration_file.h"
#include "vo_process/node/unused_inputs.h"
#include "vo_process/node/vo_messages.h"
#include "vo_process/tracking/odometry.h"

namespace plslam::vo {
namespace {

// Frames kept while the tracker waits; the oldest are dropped.
constexpr size_t kMaxWaitingFrames = 8;
// A time stamp that goes back by less belongs to the same stream.
constexpr uint64_t kClockStep_ns = 1'000'000'000;
constexpr std::chrono::milliseconds kWaitTick(200);
// Least number of features of a relocalisation request.
constexpr size_t kLeastToAsk = 20;
constexpr std::chrono::milliseconds kAskPeriod(500);
constexpr std::chrono::milliseconds kFinishTick(50);
// Number of frames after which the self-calibration is written, because a robot may be switched off.
constexpr int64_t kKeepLearnedEvery = 500;

}  // namespace

VoNode::VoNode(bus::Process& process, const VoOptions& options)
    : process_(process),
      options_(options),
      settings_(ToYaml("vo", options_)),
      report_(process),
      keyframes_(process.bus()),
      relocalisation_(process.bus()),
      inputs_(process, options, [this] { ProcessWaiting(); }),
      checkpoint_(options.state_file),
      resend_(process.bus()),
      camera_(
          process.bus(), [this](const RigCalibration& rig) { OnCamera(rig); },
          [this] { report_.Count("cameras.rejected", 1); }),
      frames_(process.bus(), bus::FrameSubscriber::Mode::kReliable, [this](const Frame& f) { OnFrame(f); }) {
  session_.id = SessionId(process.bus().source().value);
  // The left and the right image have a thread each; more threads inside OpenCV would slow them down.
  cv::setNumThreads(1);
  process_.bus().Subscribe<stream_t>(bus::kStream, [this](const stream_t& m) { OnStream(m); });
  process_.bus().Subscribe<status_t>(bus::kStatus, [this](const status_t& m) { OnStatus(m); });
  // Frames may have waited for the camera of their publisher, which is the one in use.
  process_.bus().Every(kFinishTick, [this] { ProcessWaiting(); });
  if (options_.map.enabled) SubscribeToMap();
  WarnOfUnusedInputs(process_, options_);
  process_.SetConfiguration(settings_);
  Restore();
}

/// The state is for the next start, except after an exception, which the same state might cause again. No player resends
/// the frames of an ended stream, so the state must contain their last keyframe.
VoNode::~VoNode() {
  KeepLearned(options_.self_calibration_file, camera_.bytes(), odometry_);
  const bool failed = std::uncaught_exceptions() > 0;
  if (!failed && announced_frames_ >= 0) PublishKeyframe();
  failed ? checkpoint_.Drop() : checkpoint_.Release();
}

void VoNode::OnCamera(const RigCalibration& rig) {
  try {
    front_end_.emplace(rig, options_);
  } catch (const std::exception& error) {
    front_end_.reset();
    process_.SetState(process_state::kFailed, error.what());
    throw;
  }
  if (rig_) {
    LogInfo("another camera '{}': starting a new session", rig.name);
    // Waits and waiting frames belong to the old session.
    EndWaits();
    waiting_.clear();
  }
  rig_ = rig;
  inputs_.OnCamera(rig);
  report_.OnCamera();
  odometry_.reset();  // its self-calibration belongs to the other camera
  ProcessWaiting();
}

void VoNode::OnFrame(const Frame& frame) {
  camera_.Follow(frame.source);
  if (IsRepeated(frame)) return AnswerAgain(frame);
  resend_.SetPlayer(frame.source);
  if (MissesFramesBefore(frame)) {
    if (!resend_.is_open()) resend_.Send(session_);
  } else if (resend_.is_open()) {
    // Frames that arrived too early are sent again.
    resend_.End();
    waiting_.clear();
  }
  if (WaitsFor() == Wait::kNothing && waiting_.empty() && !AwaitsOthers(frame)) return Track(frame);
  const auto is_same = [&](const Frame& other) {
    return frame.source == other.source && frame.images.frame_id == other.images.frame_id;
  };
  if (frame.lockstep && std::ranges::any_of(waiting_, is_same)) return;
  if (waiting_.size() == kMaxWaitingFrames) {
    // A player in lockstep sends a frame again until it has the pose, and the oldest one is due first.
    const bool has_camera = WaitsFor() != Wait::kCamera;
    if (frame.lockstep && has_camera) return;
    report_.Count(has_camera ? "frames.dropped_waiting" : "frames.without_camera", 1);
    waiting_.erase(waiting_.begin());
  }
  waiting_.push_back(frame);
}

bool VoNode::IsRepeated(const Frame& frame) const {
  if (frame.source == session_.last_source) return frame.images.frame_id <= session_.last_frame_id;
  // A restarted player may not have received the last poses.
  return frame.images.frame_id > 0 && session_.FindPose(frame.images) != nullptr;
}

/// The player did not receive the pose, or has gone back for a tracker that did not need it.
void VoNode::AnswerAgain(const Frame& frame) {
  report_.Count("frames.repeated", 1);
  const pose_t* pose = frame.lockstep ? session_.FindPose(frame.images) : nullptr;
  if (pose != nullptr) process_.bus().Publish(bus::kPose, pose_t(*pose));
}

VoNode::Wait VoNode::WaitsFor() const {
  if (!front_end_ || camera_.awaits_rig()) return Wait::kCamera;
  if (IsLocaliseOnly() && map_ && !map_->has_map()) return Wait::kFirstMap;
  if (map_ && map_->wait().awaited()) return Wait::kMap;
  if (relocalisation_.wait().awaited()) return Wait::kRelocalisation;
  return resend_.is_open() ? Wait::kOlderFrames : Wait::kNothing;
}

bool VoNode::AwaitsOthers(const Frame& frame) {
  const std::optional<int64_t> prev_t_ns = odometry_ ? std::optional(session_.last_t_ns) : std::nullopt;
  return inputs_.Awaits(frame, prev_t_ns, waiting_.size() >= kMaxWaitingFrames);
}

void VoNode::ProcessWaiting() {
  if (!map_ || !map_->wait().awaited()) PublishKeyframe();
  while (WaitsFor() == Wait::kNothing && !waiting_.empty() && !AwaitsOthers(waiting_.front())) {
    const Frame frame = std::move(waiting_.front());
    waiting_.erase(waiting_.begin());
    IsRepeated(frame) ? AnswerAgain(frame) : Track(frame);
  }
  FinishIfDone();
}

void VoNode::EndWaits() {
  if (map_) map_->wait().End();
  relocalisation_.End();
}

void VoNode::OnStatus(const status_t& message) {
  const double now_s = bus::NowS();
  if (process_name::SendsFrames(message.process)) resend_.SetPlayer(SourceId(message.header.source), message.process);
  if (message.process == process_name::kMapping && map_) map_->wait().OnSignOfLife(now_s);
  if (message.process == process_name::kLoop) relocalisation_.OnLoopProcess(SourceId(message.header.source), now_s);
}

void VoNode::OnStream(const stream_t& message) {
  announced_frames_ = message.event == stream_event::kEnd ? message.n_frames : -1;
  FinishIfDone();
}

void VoNode::SubscribeToMap() {
  map_.emplace(
      process_.bus(), options_.map.localise_only, session_, [this] { FollowOrders(); }, [this] { OnMap(); });
  process_.bus().Subscribe<relocalisation_t>(bus::kRelocalisation,
                                             [this](const relocalisation_t& m) { OnRelocalisation(m); });
  process_.bus().Every(kWaitTick, [this] { GiveUpWaits(); });
}

void VoNode::GiveUpWaits() {
  const bool no_map = map_->GiveUp(bus::NowS());
  const bool no_result = relocalisation_.wait().GiveUp(bus::NowS());
  if (no_result) LogWarning("no loop_process is found: a lost camera is not relocalised");
  if (no_map || no_result) ProcessWaiting();
}

bool VoNode::IsLocaliseOnly() const { return map_ ? map_->localise_only() : options_.map.localise_only; }

/// A user replaced the map, or switched localisation-only mode on or off: open waits would not end. After
/// localisation-only mode a new session begins at the current pose, since the map lacks keyframes of the old one.
void VoNode::FollowOrders() {
  if (!odometry_) return;
  EndWaits();
  const bool grows = !map_->localise_only() && odometry_->localise_only();
  odometry_->SetLocaliseOnly(map_->localise_only());
  if (map_->IsOfAnotherMap()) {
    LogInfo("the map was replaced: starting a new session");
    BeginSession();
  } else if (grows) {
    BeginSessionHere();
  }
  ProcessWaiting();
}

void VoNode::OnMap() {
  const auto awaited = map_->wait().awaited();
  const int64_t oldest = awaited ? *awaited : map_->adopted_keyframe_id() + 1;
  const bool takes_effect = odometry_ && (awaited || !session_.lockstep) && map_->Has(oldest);
  if (session_.map_id == MapId()) session_.map_id = map_->map_id();
  // In lockstep the first keyframe of a map is awaited for its anchor alone.
  if (takes_effect) AdoptMap(oldest > 0 || !session_.lockstep || map_->HasOthers());
  if (awaited && !takes_effect) return;
  map_->wait().End();
  ProcessWaiting();
}

void VoNode::AdoptMap(bool landmarks) {
  if (!session_.anchor.is_anchored()) session_.anchor.OnMap(map_->IsConnected());
  if (landmarks) map_->Adopt(*odometry_);
}

/// Whether T_w_odom is known. In localisation-only mode no keyframe of the session shows it.
bool VoNode::IsAnchored() const {
  const bool is_in_map = !map_ || (IsLocaliseOnly() ? odometry_->is_in_map() : session_.anchor.is_anchored());
  return is_in_map && !(map_ && odometry_->is_unanchored());
}

/// In lockstep the map with the previous keyframe takes effect when this keyframe has been made.
void VoNode::AwaitMap(int64_t keyframe_id) {
  if (!map_ || !session_.lockstep || keyframe_id == 0) return;
  if (!map_->Has(keyframe_id - 1)) return map_->wait().Begin(keyframe_id - 1, bus::NowS());
  AdoptMap(true);
}

void VoNode::BeginSession() {
  EndWaits();
  PublishKeyframe();
  NameSession();
  KeepLearned(options_.self_calibration_file, camera_.bytes(), odometry_);
  odometry_.emplace(front_end_->camera(), options_, front_end_->shutter(), MountedImuOf(*rig_));
  odometry_->SetLocaliseOnly(IsLocaliseOnly());
  LoadLearned(options_.self_calibration_file, camera_.bytes(), *odometry_);
}

/// Begins a session at the current pose in the map: its first keyframe observes landmarks of it.
void VoNode::BeginSessionHere() {
  held_keyframe_.reset();
  NameSession();
  odometry_->BeginSession();
}

void VoNode::NameSession() {
  // A session restored from another tracker is not numbered before our own.
  const bool is_first = session_.last_frame_id < 0;
  session_.Begin(is_first ? session_.id : SessionId(std::max(session_.id.value + 1, process_.bus().source().value)));
  if (map_ && map_->has_map()) session_.map_id = map_->map_id();
  if (map_) map_->BeginSession();
}

/// Whether the frame continues the stream, but its time stamp is slightly before the previous one.
bool VoNode::IsTooEarly(const Frame& frame) const {
  const bool resumes =
      odometry_ && frame.source == session_.last_source && frame.images.frame_id > session_.last_frame_id;
  // Unsigned: time stamps may have any value.
  const uint64_t back_ns = static_cast<uint64_t>(session_.last_t_ns) - static_cast<uint64_t>(frame.images.t_ns);
  return resumes && frame.images.t_ns < session_.last_t_ns && back_ns < kClockStep_ns;
}

void VoNode::Track(const Frame& frame) {
  const bool too_early = IsTooEarly(frame);
  if (!odometry_ || (frame.images.t_ns < session_.last_t_ns && !too_early)) {
    BeginSession();
    session_.anchor.Begin(frame.images.t_ns);
  }
  session_.lockstep = frame.lockstep;
  inputs_.Use(frame, session_.last_t_ns, *front_end_, *odometry_, report_);
  if (!too_early) session_.last_t_ns = frame.images.t_ns;
  StageTimer timer(bus::NowMs);
  const OdometryResult result = timer.Time(stage_name::kTotal, [&] {
    StereoFeatures features = too_early ? NoFeatures(frame.images) : SeeFeatures(frame.images, timer);
    return timer.Time("track", [&] { return odometry_->Track(session_.last_t_ns, std::move(features)); });
  });
  // Publish the pose first: the player waits for it.
  PublishPose(frame, result, timer.stages());
  PublishTracks(frame, result);
  session_.last_frame_id = frame.images.frame_id;
  session_.last_source = frame.source;
  restored_ = false;
  NoteAnchor(frame, result);
  const bool requests = NeedsRelocalisation(frame, result);
  if (result.keyframe) MakeKeyframe(frame, result, requests);
  if (requests) RequestRelocalisation(frame, result);
  session_.follows_keyframe = result.keyframe && !requests;
  report_.SetState(process_state::kRunning);
  report_.Count("frames", 1);
  if (report_.frames() % kKeepLearnedEvery == 0)
    KeepLearned(options_.self_calibration_file, camera_.bytes(), odometry_);
  report_.Count("frames.skipped", frame.skipped);
  if (StateOf(result) == TrackingState::kLost) report_.Count(kFramesLost, 1);
  if (result.carried) report_.Count(kFramesCarried, 1);
  if (result.is_followed) report_.Count("frames.followed", 1);
  if (result.keyframe) report_.Count("keyframes", 1);
  report_.LookAt(frame.images, result.features, result.is_followed || rig_->kind == RigCalibration::Kind::kRgbd);
  report_.ReportVerticalDisparity(odometry_->calibration().rows(), front_end_->camera());
  report_.ReportCameraErrors(odometry_->calibration());
  report_.ReportImu(odometry_->motion());
  report_.ReportWarnings();
  FinishIfDone();
}

StereoFeatures VoNode::SeeFeatures(const StereoImages& images, StageTimer& timer) {
  try {
    return odometry_->SeePair(*front_end_, images, timer);
  } catch (const std::exception& error) {
    LogWarning("frame {}: {}", images.frame_id, error.what());
    report_.Count("frames.bad", 1);
    return {};
  }
}

/// Result for a frame with an impossible time stamp: no features.
StereoFeatures VoNode::NoFeatures(const StereoImages& images) {
  report_.CountTooEarly(images.frame_id);
  return {};
}

/// Published state: in localisation-only mode a camera without a known place in the map is lost.
TrackingState VoNode::StateOf(const OdometryResult& result) const {
  return !IsLocaliseOnly() || IsAnchored() ? result.state : TrackingState::kLost;
}

/// Cancels an open request after a jump, because its result concerns the pose before. While the camera is unanchored,
/// the result is still valid.
void VoNode::NoteAnchor(const Frame& frame, const OdometryResult& result) {
  if (result.jumped || (result.state == TrackingState::kRecovered && !odometry_->is_unanchored()))
    relocalisation_.Cancel();
  const bool lost = StateOf(result) == TrackingState::kLost;
  const bool unanchored =
      session_.anchor.OnFrame(frame.images.t_ns, lost, result.relocalised, odometry_->is_unanchored());
  if (!IsLocaliseOnly()) report_.CountUnanchored(unanchored);
}

/// Requested if the camera is lost; in a growing map, if it has been unanchored for a short time; in localisation-only
/// mode, after a keyframe with few landmarks of the map. A tracker restored from a keyframe sends the request of the
/// previous tracker, since requests follow the keyframe.
bool VoNode::NeedsRelocalisation(const Frame& frame, const OdometryResult& result) const {
  if (StateOf(result) == TrackingState::kLost) return true;
  if (IsLocaliseOnly()) {
    return session_.follows_keyframe && TrackedOfMap(result) < options_.tracking.weak_inliers;
  }
  const bool unanchored = session_.anchor.state() == SessionAnchor::State::kUnanchored || odometry_->is_unanchored();
  return unanchored && !result.keyframe && session_.anchor.IsRecent(frame.images.t_ns);
}

void VoNode::RequestRelocalisation(const Frame& frame, const OdometryResult& result) {
  if (!map_ || !options_.relocalisation.enabled || map_->map().keyframes().empty()) return;
  const double now_s = bus::NowS();
  if (!relocalisation_.IsDue(frame.lockstep, now_s)) return;
  if (result.features.points.size() + result.features.lines.size() < kLeastToAsk) return;
  Keyframe asked;
  asked.name.session = session_.id;
  asked.t_ns = frame.images.t_ns;
  asked.frame_id = frame.images.frame_id;
  asked.previous_keyframe_id = IsLocaliseOnly() ? -1 : session_.last_keyframe_id;
  asked.name.number = asked.previous_keyframe_id + 1;
  asked.lockstep = frame.lockstep;
  asked.camera = front_end_->camera();
  asked.SetFeatures(result.features);
  relocalisation_.Ask(std::move(asked), result.T_odom_c, now_s);
  report_.Count("relocalisation.asked", 1);
}

/// Keyframes made since the camera became unanchored say nothing new about its place.
bool VoNode::IsIndependentOfTracker(const Map& map, KeyframeId keyframe_id) const {
  const MapKeyframe* keyframe = map.FindKeyframe(keyframe_id);
  if (keyframe == nullptr || keyframe->name.session != session_.id) return true;
  return session_.anchor.is_anchored() && keyframe->t_ns <= session_.anchor.t_ns();
}

void VoNode::OnRelocalisation(const relocalisation_t& message) {
  const std::optional<Relocalisation> result = bus::FromMessage(message);
  if (!result || !odometry_) return;
  const std::optional<SE3> T_w_odom = relocalisation_.Close(*result, session_);
  if (!T_w_odom) return;
  const Map& map = map_->map();
  if (result->found && IsIndependentOfTracker(map, result->keyframe_id) &&
      odometry_->Relocalise(map, result->keyframe_id, *T_w_odom)) {
    report_.Count("relocalisation.found", 1);
  }
  ProcessWaiting();
}

void VoNode::SetHeader(const Frame& frame, header_t& header) const {
  header.session = session_.id.value;
  header.t_ns = frame.images.t_ns;
}

void VoNode::PublishPose(const Frame& frame, const OdometryResult& result, const std::vector<StageTime>& stages) {
  pose_t message = ToPoseMessage(result, odometry_->T_w_odom(), IsAnchored(), stages);
  SetHeader(frame, message.header);
  message.frame_id = frame.images.frame_id.value;
  message.n_skipped_frames = frame.skipped;
  message.age_ms = 1e3 * (bus::NowS() - frame.came_s);
  if (IsLocaliseOnly()) {
    message.keyframe_id = -1;
    message.state = static_cast<int8_t>(StateOf(result));
    if (StateOf(result) != result.state) {
      for (int i = 0; i < 6; ++i) message.covariance[7 * i] += UnknownMotion()(i, i);
    }
  }
  process_.bus().Publish(bus::kPose, message);
  session_.Remember(std::move(message));
}

void VoNode::PublishTracks(const Frame& frame, const OdometryResult& result) {
  tracks_t message = ToTracksMessage(result, process_.bus().largest_message_bytes());
  SetHeader(frame, message.header);
  message.frame_id = frame.images.frame_id.value;
  process_.bus().Publish(frame.lockstep ? bus::kTracks : bus::kTracksLive, message);
  if (result.bodies.empty()) return;
  bodies_t bodies = ToBodiesMessage(result.bodies);
  SetHeader(frame, bodies.header);
  bodies.frame_id = frame.images.frame_id.value;
  process_.bus().Publish(bus::kBodies, bodies);
}

/// In localisation-only mode a keyframe only adopts the local map around it.
void VoNode::MakeKeyframe(const Frame& frame, const OdometryResult& result, bool requests) {
  session_.last_keyframe_id = result.keyframe->id;
  if (IsLocaliseOnly()) {
    if (map_) odometry_->AdoptAround(map_->map());
    if (StateOf(result) == TrackingState::kLost) return checkpoint_.Drop();
    Keyframe none;
    none.name.number = -1;
    // The state contains no open request: a tracker that crashes after this request continues from an older keyframe.
    if (!requests) KeepState(none);
    return;
  }
  Keyframe keyframe = ToKeyframe(result, front_end_->camera());
  keyframe.name.session = session_.id;
  keyframe.t_ns = frame.images.t_ns;
  keyframe.frame_id = frame.images.frame_id;
  keyframe.lockstep = frame.lockstep;
  keyframe.map_id = session_.map_id;
  AwaitMap(keyframe.name.number);
  held_keyframe_ = std::move(keyframe);
  if (!map_ || !map_->wait().awaited()) PublishKeyframe();
}

/// Writes the state first; otherwise an older state could lead to another keyframe with this number. In lockstep the
/// keyframe is held until the map of the previous one is adopted, so that a tracker restored from the state finds the
/// map as this one left it.
void VoNode::PublishKeyframe() {
  if (!held_keyframe_) return;
  const Keyframe keyframe = *std::exchange(held_keyframe_, std::nullopt);
  KeepState(keyframe);
  keyframes_.Publish(keyframe);
  AwaitAnchor(keyframe);
}

/// In lockstep the frames after the first keyframe wait until it is in the map: the camera may be somewhere in it.
void VoNode::AwaitAnchor(const Keyframe& first) {
  if (!map_ || !session_.lockstep || first.name.number != 0 || map_->Has(0)) return;
  map_->wait().Begin(0, bus::NowS());
}

/// Continues with the state as of the newest keyframe. In lockstep that keyframe may not have been published, and later
/// frames are requested again; a live stream continues with a gap.
void VoNode::Restore() {
  if (!checkpoint_.is_on()) return;
  process_.bus().Every(kAskPeriod, [this] { RepeatResendRequest(); });
  try {
    if (const std::optional<TrackerState> state = checkpoint_.Take(settings_)) Restore(*state);
  } catch (const std::exception& error) {
    LogWarning("starting a new session: {}", error.what());
    odometry_.reset();
  }
}

void VoNode::Restore(const TrackerState& state) {
  camera_.Restore(state.camera, state.session.last_source);
  if (!front_end_) return;
  odometry_.emplace(front_end_->camera(), options_, front_end_->shutter(), MountedImuOf(*rig_));
  archive::FromBytes(state.odometry, *odometry_);
  odometry_->SetLocaliseOnly(IsLocaliseOnly());
  session_ = state.session;
  resend_.SetPlayer(session_.last_source);
  if (map_) map_->Restore(state.localise_only != 0, state.map_is_fixed != 0);
  session_.follows_keyframe = true;
  session_.last_keyframe_id = state.keyframe.name.number;
  if (map_) map_->BeginSession(state.adopted_keyframe_id);
  restored_ = true;
  LogInfo("resuming after frame {} of the session", session_.last_frame_id);
  // Before the first frame arrives.
  if (state.keyframe.name.number >= 0) AwaitAnchor(state.keyframe);
  if (session_.lockstep) resend_.Open();
  process_.bus().Post([this, keyframe = state.keyframe] {
    if (keyframe.name.number >= 0) keyframes_.Publish(keyframe);
    // The last pose of the crashed tracker may be lost, and a restarted player needs it.
    if (!session_.recent.empty()) process_.bus().Publish(bus::kPose, pose_t(session_.recent.back()));
    if (session_.lockstep) resend_.Send(session_);
  });
}

/// If writing fails the process continues, with a higher cost of a crash.
void VoNode::KeepState(const Keyframe& keyframe) {
  if (!checkpoint_.is_on() || !odometry_) return;
  TrackerState state;
  state.settings = settings_;
  state.camera = camera_.bytes();
  state.session = session_;
  state.localise_only = IsLocaliseOnly() ? 1 : 0;
  state.map_is_fixed = map_ && map_->map_is_fixed() ? 1 : 0;
  state.adopted_keyframe_id = map_ ? map_->adopted_keyframe_id() : -1;
  state.odometry = archive::ToBytesOf(checkpoint_.odometry_bytes(), *odometry_);
  state.keyframe = keyframe;
  if (checkpoint_.Keep(state)) report_.Count("state.written", 1);
}

/// A player is ahead of a tracker that was restored from its newest keyframe, as a player started with it may be.
bool VoNode::MissesFramesBefore(const Frame& frame) const {
  const bool continues = frame.lockstep && session_.lockstep && odometry_ && frame.images.t_ns > session_.last_t_ns;
  const bool may_go_back = restored_ || frame.source != session_.last_source;
  return continues && may_go_back && frame.images.frame_id.value > session_.last_frame_id.value + 1 &&
         checkpoint_.is_on();
}

void VoNode::RepeatResendRequest() {
  if (!resend_.RepeatOrEnd(session_)) return;
  if (!waiting_.empty())
    LogWarning("no player resends the frames after {}: they are skipped", session_.last_frame_id);
  ProcessWaiting();
}

/// Finished means that the readers, too, have every message: `plslam run` ends the run then.
void VoNode::FinishIfDone() {
  constexpr std::chrono::milliseconds kNow{0};
  const bool done =
      announced_frames_ >= 0 && session_.last_frame_id.value + 1 >= announced_frames_ && !held_keyframe_;
  if (done && !report_.finished() && process_.bus().Flush(kNow)) report_.Finish();
}

bus::ProcessSpec VoSpec() {
  bus::ProcessSpec spec;
  spec.name = process_name::kVo;
  spec.description = "Stereo odometry with points and lines: frames in, poses and keyframes out.";
  spec.examples =
      "  vo_process\n"
      "  vo_process --config config/plslam.yaml --set vo.features.features=points\n"
      "  vo_process --url udpm://239.255.76.67:7667?ttl=1 --prefix front/";
  spec.waits_for = "a camera and frames of a player";
  spec.results = {{"frames", "frames tracked"}, {kFramesLost, "of them lost"}, {"keyframes", "keyframes"}};
  spec.make_node = bus::NodeWithOptions<VoNode, VoOptions>(spec.name);
  return spec;
}

}  // namespace plslam::vo
